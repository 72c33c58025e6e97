//! A path of the room of proposals in double precision: where its vertices move when it is followed again a little off, through the same
//! mirrors and spheres, and the areas that they sweep, by central differences.

use crate::proposals::{BALL, INDEX, LAMP, Sphere};
use crate::steps::{exact, position};
use glam::{DMat2, DVec2, DVec3, Vec2};
use halflight_kernel::bsdf::event;
use halflight_kernel::math::Ray as KernelRay;
use halflight_kernel::scene::records::Camera;
use halflight_kernel::scene::{NONE, camera};
use halflight_kernel::transport::markov::veach::ChainPath;

#[derive(Clone, Copy, Debug)]
enum Surface {
    Plane { point: DVec3, normal: DVec3 },
    Sphere(Sphere),
}

impl Surface {
    /// Where a ray meets it, near a point of it.
    fn meet(&self, ray: Ray, near: DVec3) -> DVec3 {
        let t = match self {
            Surface::Plane { point, normal } => {
                (*point - ray.origin).dot(*normal) / ray.direction.dot(*normal)
            }
            Surface::Sphere(Sphere { center, radius }) => {
                let from_center = ray.origin - *center;
                let b = from_center.dot(ray.direction);
                let closest = (from_center - ray.direction * b).length_squared();
                let half = (radius * radius - closest).sqrt();
                // One of the two roots.
                let wanted = (near - ray.origin).dot(ray.direction);
                -b + half.copysign(wanted + b)
            }
        };
        ray.origin + ray.direction * t
    }

    fn normal(&self, at: DVec3) -> DVec3 {
        match self {
            Surface::Plane { normal, .. } => *normal,
            Surface::Sphere(Sphere { center, .. }) => (at - *center).normalize(),
        }
    }
}

/// A ray.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

/// The rays of a camera through a lens point: origin and direction are linear in the film position.
struct Film {
    corners: [Ray; 3],
    size: DVec2,
}

impl Film {
    fn new(camera: &Camera, u_lens: Vec2) -> Film {
        let size = Vec2::new(camera.film_size[0] as f32, camera.film_size[1] as f32);
        let exact = |ray: KernelRay| Ray {
            origin: ray.origin.as_dvec3(),
            direction: ray.direction.as_dvec3(),
        };
        let at =
            |x: f32, y: f32| exact(camera::ray_through(camera, size * Vec2::new(x, y), u_lens));
        let pinhole = Vec2::splat(0.5);
        let axis = exact(camera::ray_through(camera, size * 0.5, pinhole)).direction;
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)].map(|ray| Ray {
            direction: ray.direction / ray.direction.dot(axis),
            ..ray
        });
        Film {
            corners,
            size: size.as_dvec2(),
        }
    }

    fn ray(&self, film: DVec2) -> Ray {
        let at = film / self.size;
        let linear = |[a, b, c]: [DVec3; 3]| a + (b - a) * at.x + (c - a) * at.y;
        Ray {
            origin: linear(self.corners.map(|ray| ray.origin)),
            direction: linear(self.corners.map(|ray| ray.direction)).normalize(),
        }
    }
}

/// A path.
pub struct Replay<'a> {
    path: &'a ChainPath,
    surfaces: Vec<Surface>,
    film: Film,
}

impl<'a> Replay<'a> {
    pub fn new(camera: &Camera, path: &'a ChainPath) -> Replay<'a> {
        let surface = |i: usize| {
            let (vertex, at) = (&path.vertices[i].point, position(path, i));
            let is_on = |sphere: &&Sphere| {
                let distance = at.distance(sphere.center);
                (distance - sphere.radius).abs() < 1e-4 * sphere.radius
            };
            if let Some(sphere) = [BALL, LAMP].iter().find(is_on) {
                return Surface::Sphere(*sphere);
            }
            // A point light has no surface but the one that faces what it shines on.
            let normal = if i == 0 && vertex.emitter == NONE {
                path.next_direction(0)
            } else {
                vertex.geometric_normal
            };
            Surface::Plane {
                point: at,
                normal: exact(normal),
            }
        };
        Replay {
            path,
            surfaces: (0..path.edges()).map(surface).collect(),
            film: Film::new(camera, path.u_lens),
        }
    }

    /// The ray that leaves the lens.
    pub fn ray(&self, film: DVec2) -> Ray {
        self.film.ray(film)
    }

    /// Where a ray meets the surface of a vertex.
    pub fn meet(&self, ray: Ray, i: usize) -> DVec3 {
        self.surfaces[i].meet(ray, position(self.path, i))
    }

    /// The ray that leaves by the discrete event of vertex `i`.
    pub fn scatter(&self, ray: Ray, i: usize) -> Ray {
        let origin = self.meet(ray, i);
        let normal = self.surfaces[i].normal(origin);
        let cosine = ray.direction.dot(normal);
        let direction = if self.path.vertices[i].event & event::TRANSMISSION == 0 {
            ray.direction - normal * (2.0 * cosine)
        } else {
            // Spheres have their normals outside.
            let eta = if cosine < 0.0 { 1.0 / INDEX } else { INDEX };
            let along = ray.direction * eta - normal * (cosine * eta);
            along + normal * (1.0 - along.length_squared()).sqrt().copysign(cosine)
        };
        Ray { origin, direction }
    }

    /// Where a ray goes that meets vertices one after the other, the last of which is no discrete event or is the end.
    pub fn follow(&self, mut ray: Ray, vertices: impl DoubleEndedIterator<Item = usize>) -> DVec3 {
        let mut vertices = vertices.peekable();
        loop {
            let i = vertices.next().expect("a vertex");
            if vertices.peek().is_none() {
                return self.meet(ray, i);
            }
            ray = self.scatter(ray, i);
        }
    }

    /// Coordinates of a point near vertex `i` in the plane that touches it there.
    pub fn on_plane(&self, i: usize, point: DVec3) -> [f64; 2] {
        let at = position(self.path, i);
        let (s, t) = self.surfaces[i].normal(at).any_orthonormal_pair();
        [s, t].map(|tangent| tangent.dot(point - at))
    }

    /// The logarithm of the product of d A_i / d c_i over the vertices i that are no discrete events: c_i the direction at the next such vertex, the
    /// film position where there is none.
    pub fn ln_areas_per_direction(&self) -> f64 {
        let k = self.path.edges();
        let is_end = |i: usize| i == 0 || i == k || self.path.vertices[i].is_smooth();
        let mut next = k;
        let mut sum = 0.0;
        for i in (0..k).rev().filter(|&i| is_end(i)) {
            let between = (i..next).rev();
            let moved = |step: DVec2| {
                let ray = if next == k {
                    self.ray(self.path.film.as_dvec2() + step)
                } else {
                    let old = exact(self.path.previous_direction(next));
                    let (s, t) = old.any_orthonormal_pair();
                    Ray {
                        origin: position(self.path, next),
                        direction: (old + s * step.x + t * step.y).normalize(),
                    }
                };
                DVec2::from(self.on_plane(i, self.follow(ray, between.clone())))
            };
            let h = if next == k { 1e-4 } else { 1e-6 };
            let column = |axis: DVec2| (moved(axis * h) - moved(-axis * h)) / (2.0 * h);
            let matrix = DMat2::from_cols(column(DVec2::X), column(DVec2::Y));
            sum += matrix.determinant().abs().ln();
            next = i;
        }
        sum
    }
}
