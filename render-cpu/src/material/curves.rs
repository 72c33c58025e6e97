//! The data of a material's diagrams.
//!
//! All directions lie in the plane of incidence of a flat point at the middle of the texture square: wi at angles from the
//! normal to the left, wo anywhere. Transmission is unscaled (importance), so that albedos are shares of energy.

use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::local_roughness::local_beckmann_roughness;
use halflight_kernel::bsdf::{Bsdf, event, mode};
use halflight_kernel::math::{Frame, luminance};
use halflight_kernel::scene::{NONE, SurfacePoint, Tables};

/// Angles of incidence of the lobes in degrees.
pub const INCIDENCES: [f32; 4] = [0.0, 30.0, 60.0, 80.0];

/// Steps between two directions of a slice in degrees.
const STEP: f32 = 0.25;

/// Samples per estimate of an albedo: a square grid, jittered by a golden-ratio sequence in the choice of the lobe.
const GRID: u32 = 48;

/// A lobe in the plane of incidence.
#[derive(Clone, Debug, Default)]
pub struct Slice {
    /// Angle of wo from the normal in degrees, positive to the right, and the luminance of f |cos|.
    pub values: Vec<[f32; 2]>,
    /// Discrete directions: the angle, and the share of the light that is scattered there.
    pub discrete: Vec<[f32; 2]>,
    /// Angle of wo, and the local Beckmann roughness there, where the material scatters to the side of wi.
    pub roughness: Vec<[f32; 2]>,
}

/// The material at one point.
#[derive(Clone, Copy)]
pub struct Probe<'a> {
    tables: Tables<'a>,
    point: SurfacePoint,
}

/// The direction in the plane of incidence at `degrees` from the normal, positive along x.
fn direction(degrees: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(sin, 0.0, cos)
}

impl<'a> Probe<'a> {
    /// The middle of the unit square of textures.
    pub fn new(tables: Tables<'a>, material: u32) -> Probe<'a> {
        let point = SurfacePoint {
            position: Vec3::ZERO,
            position_error: 0.0,
            geometric_normal: Vec3::Z,
            frame: Frame::LOCAL,
            uv: Vec2::splat(0.5),
            barycentric: Vec2::ZERO,
            dp_du: Vec3::X,
            dp_dv: Vec3::Y,
            dn_du: Vec3::ZERO,
            dn_dv: Vec3::ZERO,
            shape: 0,
            primitive: NONE,
            instance: 0,
            material,
            emitter: NONE,
        };
        Probe { tables, point }
    }

    fn bsdf(&self, wi: Vec3) -> Bsdf {
        Bsdf::at(&self.tables, &self.point, wi, mode::IMPORTANCE)
    }

    /// The lobe for light that is seen at `incidence` degrees.
    pub fn slice(&self, incidence: f32) -> Slice {
        let wi = direction(-incidence);
        let bsdf = self.bsdf(wi);
        let data = self.tables.data;
        let mut slice = Slice {
            discrete: self.discrete(&bsdf, wi),
            ..Slice::default()
        };
        let steps = (360.0 / STEP) as i32;
        let mut angles: Vec<f32> = (0..=steps).map(|i| i as f32 * STEP - 180.0).collect();
        // Peaks narrower than a step are at the mirror direction.
        angles.extend((-100..=100).map(|i| incidence + i as f32 * 0.01));
        angles.sort_by(f32::total_cmp);
        for angle in angles {
            let wo = direction(angle);
            let value = luminance(bsdf.eval_cosine(data, wi, wo));
            slice.values.push([angle, value]);
            if value > 0.0 && wo.z > 0.0 {
                slice
                    .roughness
                    .push([angle, local_beckmann_roughness(&bsdf, data, wi, wo)]);
            }
        }
        slice
    }

    /// Discrete directions of the lobe with their share of the light.
    fn discrete(&self, bsdf: &Bsdf, wi: Vec3) -> Vec<[f32; 2]> {
        let mut found: Vec<[f32; 2]> = Vec::new();
        let n = GRID * GRID;
        for (u1, u2) in grid() {
            let s = bsdf.sample(self.tables.data, wi, u1, u2);
            if s.pdf <= 0.0 || s.event & event::DELTA == 0 {
                continue;
            }
            let angle = s.wo.x.atan2(s.wo.z).to_degrees();
            let share = luminance(s.weight) / n as f32;
            match found
                .iter_mut()
                .find(|entry| (entry[0] - angle).abs() < 0.01)
            {
                Some(entry) => entry[1] += share,
                None => found.push([angle, share]),
            }
        }
        found
    }

    /// Share of the light at `incidence` degrees that is scattered anywhere, per channel.
    pub fn albedo(&self, incidence: f32) -> Vec3 {
        let wi = direction(-incidence);
        let bsdf = self.bsdf(wi);
        let mut sum = Vec3::ZERO;
        for (u1, u2) in grid() {
            let s = bsdf.sample(self.tables.data, wi, u1, u2);
            if s.pdf > 0.0 {
                sum += s.weight;
            }
        }
        sum / (GRID * GRID) as f32
    }
}

/// Random numbers spread evenly over the cube.
fn grid() -> impl Iterator<Item = (f32, Vec2)> {
    (0..GRID * GRID).map(|i| {
        let u1 = (f64::from(i) * 0.618_033_988_749_895).fract() as f32;
        let cell = Vec2::new((i % GRID) as f32 + 0.5, (i / GRID) as f32 + 0.5);
        (u1.min(1.0 - f32::EPSILON), cell / GRID as f32)
    })
}
