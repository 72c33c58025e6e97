//! Functions of a few vectors: warps, frames, lobes on the disk, mollified directions, half vectors.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::bsdf::fresnel;
use halflight_kernel::glam::{Vec2, Vec3};
use halflight_kernel::manifold::disk_lobe::{self, DiskLobe};
use halflight_kernel::manifold::half_vector as half;
use halflight_kernel::manifold::slope_gaussian::SlopeGaussian;
use halflight_kernel::math::{Frame, moebius, warp};
use halflight_kernel::regularize::{cone, mollifier};

/// Arguments; a function takes the first few of each.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VectorInput {
    /// First unit vector.
    pub a: [f32; 3],
    /// Second unit vector.
    pub b: [f32; 3],
    /// A point of the unit square.
    pub u: [f32; 2],
    /// A point of the plane or disk.
    pub p: [f32; 2],
    /// Another one.
    pub q: [f32; 2],
    /// Two more numbers.
    pub x: [f32; 2],
    /// A kind.
    pub kind: u32,
}

/// What a function returns, zero beyond that.
pub type VectorOutput = [f32; 12];

/// Names of the functions.
#[allow(missing_docs)]
pub mod vector {
    pub const WARP_DISK: u32 = 0;
    pub const WARP_COSINE: u32 = 1;
    pub const WARP_SPHERE: u32 = 2;
    pub const WARP_HEMISPHERE: u32 = 3;
    pub const WARP_CONE: u32 = 4;
    pub const WARP_TRIANGLE: u32 = 5;
    pub const FRAME: u32 = 6;
    pub const REFRACT: u32 = 7;
    pub const MOEBIUS: u32 = 8;
    pub const DISK_LOBE_SAMPLE: u32 = 9;
    pub const DISK_LOBE_PDF: u32 = 10;
    pub const SLOPE_GAUSSIAN: u32 = 11;
    pub const CONE_SAMPLE: u32 = 12;
    pub const CONE_EVAL: u32 = 13;
    pub const MOLLIFIER_SAMPLE: u32 = 14;
    pub const HALF_VECTOR: u32 = 15;
    pub const HALF_VECTOR_CHARTS: u32 = 16;
    pub const HALF_VECTOR_OUTGOING: u32 = 17;
}

/// Evaluates function `function` of [`vector`].
pub fn evaluate(function: u32, input: &VectorInput) -> VectorOutput {
    let a = Vec3::new(input.a[0], input.a[1], input.a[2]);
    let b = Vec3::new(input.b[0], input.b[1], input.b[2]);
    let u = Vec2::new(input.u[0], input.u[1]);
    let p = Vec2::new(input.p[0], input.p[1]);
    let q = Vec2::new(input.q[0], input.q[1]);
    let [x, y] = input.x;
    match function {
        vector::WARP_DISK => {
            let d = warp::square_to_disk(u);
            four(d.x, d.y, warp::DISK_PDF_AREA, 0.0)
        }
        vector::WARP_COSINE => {
            let w = warp::square_to_cosine_hemisphere(u);
            direction(w, warp::cosine_hemisphere_pdf(w.z))
        }
        vector::WARP_SPHERE => direction(warp::square_to_uniform_sphere(u), 0.0),
        vector::WARP_HEMISPHERE => direction(warp::square_to_uniform_hemisphere(u), 0.0),
        vector::WARP_CONE => direction(
            warp::square_to_uniform_cone(u, x),
            warp::uniform_cone_pdf(x),
        ),
        vector::WARP_TRIANGLE => {
            let t = warp::square_to_triangle(u);
            four(t.x, t.y, 0.0, 0.0)
        }
        vector::FRAME => frame(a, b),
        vector::REFRACT => {
            let cos_i = a.dot(b);
            let eta = fresnel::relative_eta(cos_i, x);
            let (reflectance, cos_t) = fresnel::fresnel_dielectric(cos_i, x);
            two_directions(
                fresnel::reflect(a, b),
                fresnel::refract(a, b, cos_t, eta),
                reflectance,
            )
        }
        vector::MOEBIUS => {
            let z = moebius::moebius(p, q);
            let pivot = moebius::clamp_pivot(p);
            [
                z.x,
                z.y,
                moebius::moebius_jacobian(p, q),
                pivot.x,
                pivot.y,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
            ]
        }
        vector::DISK_LOBE_SAMPLE => {
            let z = disk_lobe_of(p, a, input.x).sample(u);
            four(z.x, z.y, 0.0, 0.0)
        }
        vector::DISK_LOBE_PDF => four(
            disk_lobe_of(p, a, input.x).pdf_disk(q),
            disk_lobe::exponent_of_deviation(x),
            0.0,
            0.0,
        ),
        vector::SLOPE_GAUSSIAN => {
            let gaussian = SlopeGaussian {
                center: p,
                axis: axis(a),
                deviation: Vec2::new(x, y),
            };
            let h = gaussian.sample(u);
            four(h.x, h.y, gaussian.pdf_slope(q), 0.0)
        }
        vector::CONE_SAMPLE => direction(
            cone::sample(input.kind, a, x, u),
            cone::one_minus_cos_of_tau(y),
        ),
        vector::CONE_EVAL => four(
            cone::eval(input.kind, a, b, x),
            cone::one_minus_cos_of_radius(x, y),
            cone::one_minus_cos_of_tangent(y),
            0.0,
        ),
        vector::MOLLIFIER_SAMPLE => {
            let d = mollifier::sample_2d(input.kind, u);
            let s = mollifier::sample_3d(input.kind, Vec3::new(x, u.x, u.y));
            [
                mollifier::sample_1d(input.kind, x),
                d.x,
                d.y,
                s.x,
                s.y,
                s.z,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
            ]
        }
        vector::HALF_VECTOR => {
            let h = half::half_vector(a, b, x, Vec3::Z);
            [
                h.h.x,
                h.h.y,
                h.h.z,
                h.length,
                h.sign,
                h.solid_angle_per_half_vector(b, x),
                half::projected_per_half_vector(h.h.z),
                half::slope_per_half_vector(h.h.z),
                0.0,
                0.0,
                0.0,
                0.0,
            ]
        }
        vector::HALF_VECTOR_CHARTS => charts(a, p, q),
        vector::HALF_VECTOR_OUTGOING => {
            let reflected = half::reflect(a, b);
            let refracted = half::refract(a, b, x);
            two_directions(
                reflected.wo,
                refracted.wo,
                if refracted.valid { 1.0 } else { 0.0 },
            )
        }
        _ => [0.0; 12],
    }
}

fn four(x: f32, y: f32, z: f32, w: f32) -> VectorOutput {
    [x, y, z, w, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
}

fn direction(w: Vec3, value: f32) -> VectorOutput {
    four(w.x, w.y, w.z, value)
}

fn two_directions(v: Vec3, w: Vec3, value: f32) -> VectorOutput {
    [v.x, v.y, v.z, w.x, w.y, w.z, value, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// A unit direction of the plane.
fn axis(a: Vec3) -> Vec2 {
    Vec2::new(a.x, a.y)
}

fn disk_lobe_of(center: Vec2, a: Vec3, exponent: [f32; 2]) -> DiskLobe {
    DiskLobe {
        center,
        axis: axis(a),
        exponent: Vec2::new(exponent[0], exponent[1]),
    }
}

/// Both frames around `n`, and a vector turned there and back.
fn frame(n: Vec3, v: Vec3) -> VectorOutput {
    let any = Frame::from_normal(n);
    let hung = Frame::from_normal_tangent(n, v);
    let local = any.to_local(v);
    let back = hung.to_world(local);
    [
        any.s.x, any.s.y, any.s.z, hung.t.x, hung.t.y, hung.t.z, local.x, local.y, local.z, back.x,
        back.y, back.z,
    ]
}

/// A half vector from chart to chart: `slope` in the plane, `projected` in the disk.
fn charts(n: Vec3, slope: Vec2, projected: Vec2) -> VectorOutput {
    let frame = Frame::from_normal(n);
    let s = half::slope_of_projected(projected);
    let p = half::projected_of_slope(slope);
    let h = half::half_vector_of_slope(&frame, slope);
    let g = half::half_vector_of_projected(&frame, projected);
    [
        s.x,
        s.y,
        p.x,
        p.y,
        h.x,
        h.y,
        h.z,
        g.x,
        g.y,
        g.z,
        half::projected_per_slope(slope),
        0.0,
    ]
}
