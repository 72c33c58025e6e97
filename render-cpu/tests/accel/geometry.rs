//! Scenes of bare geometry, a search of all their primitives to compare with, and rays and random numbers for them.

use crate::empty_tables::empty_tables;
use glam::{Affine3A, Vec3};
use halflight::accel::{Accel, GroupRange};
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::math::{Ray, vec3};
use halflight_kernel::scene::intersect::{ShearedRay, intersect_quadric, intersect_triangle};
use halflight_kernel::scene::*;

/// Owned geometry of a test scene.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<Triangle>,
    pub quadrics: Vec<Quadric>,
    pub instances: Vec<Instance>,
    pub groups: Vec<GroupRange>,
}

impl Geometry {
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            triangles: &self.triangles,
            quadrics: &self.quadrics,
            instances: &self.instances,
            ..empty_tables()
        }
    }

    /// Adds a triangle, with vertices of the last triangles where they are the same.
    pub fn triangle(&mut self, points: [Vec3; 3]) {
        let vertices = points.map(|p| {
            let recent = self.positions.len().saturating_sub(100);
            let bits = |p: [f32; 3]| p.map(f32::to_bits);
            let same = |q: &[f32; 3]| bits(*q) == bits(p.to_array());
            match self.positions[recent..].iter().position(same) {
                Some(place) => (recent + place) as u32,
                None => {
                    self.positions.push(p.to_array());
                    self.positions.len() as u32 - 1
                }
            }
        });
        self.triangles.push(Triangle { vertices, shape: 0 });
    }

    pub fn quadric(&mut self, kind: u32, to_world: Affine3A) {
        self.quadrics.push(Quadric {
            to_world: rows(to_world),
            to_object: rows(to_world.inverse()),
            kind,
            shape: 0,
        });
    }

    /// Everything so far from these starts on makes the next group.
    pub fn close_group(&mut self) {
        let (triangles, quadrics) = self
            .groups
            .last()
            .map_or((0, 0), |g| (g.triangles.end, g.quadrics.end));
        self.groups.push(GroupRange {
            triangles: triangles..self.triangles.len() as u32,
            quadrics: quadrics..self.quadrics.len() as u32,
        });
    }

    pub fn place(&mut self, group: u32, to_world: Affine3A) {
        self.instances.push(Instance {
            to_world: rows(to_world),
            to_object: rows(to_world.inverse()),
            root: 0,
            group,
        });
    }

    /// The nearest hit by a search of everything, in single precision with the kernel's own intersections.
    pub fn search(&self, ray: &Ray) -> Hit {
        let tables = self.tables();
        let mut hit = Hit::MISS;
        for (instance, record) in self.instances.iter().enumerate() {
            let group = &self.groups[record.group as usize];
            let origin = transform_point(&record.to_object, ray.origin);
            let direction = transform_vector(&record.to_object, ray.direction);
            let sheared = ShearedRay::new(origin, direction);
            for i in group.triangles.clone() {
                let [a, b, c] = tables.triangles[i as usize]
                    .vertices
                    .map(|v| vec3(tables.positions[v as usize]));
                let found = intersect_triangle(&sheared, a, b, c, ray.t_min, ray.t_max);
                if hit.is_behind(found.t, i, instance as u32) {
                    hit = Hit {
                        t: found.t,
                        b1: found.b1,
                        b2: found.b2,
                        primitive: i,
                        instance: instance as u32,
                    };
                }
            }
            for i in group.quadrics.clone() {
                let q = &tables.quadrics[i as usize];
                let t = intersect_quadric(
                    q.kind,
                    transform_point(&q.to_object, origin),
                    transform_vector(&q.to_object, direction),
                    ray.t_min,
                    ray.t_max,
                );
                let primitive = tables.triangles.len() as u32 + i;
                if hit.is_behind(t, primitive, instance as u32) {
                    hit = Hit {
                        t,
                        b1: 0.0,
                        b2: 0.0,
                        primitive,
                        instance: instance as u32,
                    };
                }
            }
        }
        hit
    }

    /// Whether several primitives lie at the distance of the nearest hit.
    pub fn is_shared(&self, ray: &Ray) -> bool {
        let nearest = self.search(ray);
        let mut others = self.clone();
        // Without the primitive that was found, its place stays.
        if let Some(found) = others.triangles.get_mut(nearest.primitive as usize) {
            found.vertices = [0; 3];
        }
        nearest.is_hit() && others.search(ray).t == nearest.t
    }

    /// Compares the three, and the wide trees' walk with many rays at once.
    pub fn check(&mut self, rays: &[Ray]) {
        let accel = Accel::build(self.tables(), &self.groups);
        let nodes = accel.shader_nodes(self.tables());
        for instance in &mut self.instances {
            instance.root = nodes.roots[instance.group as usize];
        }
        let tables = self.tables();
        let wide = accel.traverse(tables);
        let walk = Bvh2Traverse {
            tables,
            nodes: &nodes.nodes,
            primitive_indices: &nodes.primitive_indices,
        };
        for ray in rays {
            let expected = self.search(ray);
            for (name, hit, occluded) in [
                ("wide", wide.closest_hit(ray), wide.is_occluded(ray)),
                ("binary", walk.closest_hit(ray), walk.is_occluded(ray)),
            ] {
                assert_eq!(hit, expected, "{name} along {ray:?}");
                assert_eq!(occluded, expected.is_hit(), "{name} along {ray:?}");
            }
        }
        check_batches::<64>(&wide, rays);
        check_batches::<200>(&wide, rays);
        check_batches::<208>(&wide, &bundles(rays));
    }
}

/// Sixteen rays close to each of some rays, in front of rays that go elsewhere.
fn bundles(rays: &[Ray]) -> Vec<Ray> {
    let mut random = Random(7);
    let mut bundles = vec![];
    for (i, ray) in rays.iter().enumerate() {
        if i % 8 != 0 {
            bundles.push(*ray);
            continue;
        }
        // Whole vectors, as packets begin at multiples of sixteen.
        bundles.resize(bundles.len().next_multiple_of(16), *ray);
        let (spread, width) = ([0.0, 1e-3, 0.004][i / 8 % 3], [0.0, 1e-3][i / 8 % 2]);
        for _ in 0..16 {
            let mut other = *ray;
            // Zeros stay, as do signs.
            other.direction *= Vec3::ONE + random.point() * spread;
            other.origin += random.point() * width;
            bundles.push(other);
        }
    }
    bundles
}

/// Rays side by side meet what each meets alone; the last batch is not full. What a batch held before must not matter, so that
/// all share one.
pub fn check_batches<const N: usize>(traverse: &impl Traverse, rays: &[Ray]) {
    let mut batch: Box<RayBatch<N>> = bytemuck::zeroed_box();
    let mut hits: Box<HitBatch<N>> = bytemuck::zeroed_box();
    for rays in rays.chunks(N) {
        for (i, ray) in rays.iter().enumerate() {
            batch.set(i, ray);
        }
        traverse.closest_hits(&batch, rays.len(), &mut hits);
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(
                hits.get(i),
                traverse.closest_hit(ray),
                "batch along {ray:?}"
            );
        }
        traverse.are_occluded(&batch, rays.len(), &mut hits);
        for (i, ray) in rays.iter().enumerate() {
            let is_occluded = traverse.is_occluded(ray);
            assert_eq!(hits.is_hit(i), is_occluded, "batch along {ray:?}");
        }
    }
}

/// A map as three rows of four.
pub fn rows(m: Affine3A) -> [f32; 12] {
    let (r, t) = (m.matrix3.transpose(), m.translation);
    [
        r.x_axis.x, r.x_axis.y, r.x_axis.z, t.x, r.y_axis.x, r.y_axis.y, r.y_axis.z, t.y,
        r.z_axis.x, r.z_axis.y, r.z_axis.z, t.z,
    ]
}

/// Geometry of the world alone, with its one instance.
pub fn world(fill: impl FnOnce(&mut Geometry)) -> Geometry {
    let mut g = Geometry::default();
    fill(&mut g);
    g.close_group();
    g.place(0, Affine3A::IDENTITY);
    g
}

/// Deterministic rays from around towards a box of half this size.
pub fn rays_around(size: f32) -> Vec<Ray> {
    let mut random = Random(1);
    let mut rays = vec![];
    for i in 0..400 {
        let target = random.point() * size;
        let mut direction = random.point();
        if i % 5 == 0 {
            direction[i % 3] = 0.0;
        }
        if i % 7 == 0 {
            direction = Vec3::AXES[i % 3];
        }
        let direction = direction.normalize();
        rays.push(Ray::new(target - direction * (3.0 * size), direction));
    }
    rays
}

/// Numbers in [-1, 1) by a multiplicative generator.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}
