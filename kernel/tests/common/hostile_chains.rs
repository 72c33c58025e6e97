//! Half-vector chains where they have poles: near-singular blocks, grazing edges, indices near one, roughness near zero,
//! coincident vertices. Whatever the input, no panic; for finite input, finite output.
//!
//! One body for the fuzz target and for the test that feeds it random bytes.

#[path = "spheres.rs"]
mod spheres;

use glam::{Mat2, Vec2, Vec3};
use halflight_kernel::manifold::breakup::{probabilities_b, probabilities_c};
use halflight_kernel::manifold::chain::{
    generalized_geometry_term, half_vector_measure, measure_by_geometry_terms,
};
use halflight_kernel::manifold::exploration::explore;
use halflight_kernel::manifold::mutation::{mutate, mutation_kind, prediction_between};
use halflight_kernel::manifold::step_size::{
    disk_proposal, image_step, slope_proposal, spectrum_weights,
};
use halflight_kernel::manifold::walk::WalkOptions;
use halflight_kernel::manifold::{ChainJacobian, ChainVertex};
use halflight_kernel::math::scaled::Scaled;
use halflight_kernel::scene::{SceneView, SurfacePoint};
use spheres::Spheres;

const N: usize = 8;

/// Numbers out of the input; many of them are the awkward ones.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((b, rest)) => {
                self.0 = rest;
                *b
            }
            None => 0,
        }
    }

    fn number(&mut self) -> f32 {
        let kind = self.byte();
        let x = f32::from(self.byte()) / 127.5 - 1.0;
        match kind & 15 {
            0 => 0.0,
            1 => 1.0 + x * 1e-6,
            2 => x * 1e-7,
            3 => x * 1e-20,
            4 => x * 1e6,
            5 => x * 1e18,
            6 => f32::from_bits(u32::from_le_bytes([
                kind,
                self.byte(),
                self.byte(),
                self.byte(),
            ])),
            _ => x + f32::from(kind) * 1e-3,
        }
    }

    /// Finite.
    fn finite(&mut self) -> f32 {
        let x = self.number();
        if x.is_finite() {
            x.clamp(-1e18, 1e18)
        } else {
            0.0
        }
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.finite(), self.finite(), self.finite())
    }

    fn unit(&mut self) -> Vec3 {
        self.vector().try_normalize().unwrap_or(Vec3::Z)
    }
}

fn finite(x: Scaled) {
    assert!(x.mantissa.is_finite() && x.value().is_finite() && x.ln_abs().is_finite());
}

/// Makes a chain out of bytes and calls everything on it. Returns whether its constraints had an inverse, and whether a
/// mutation of it gave a path.
pub fn check(bytes: &[u8]) -> (bool, bool) {
    let mut input = Input(bytes);
    let len = 2 + usize::from(input.byte()) % (N - 1);
    let mut vertices = [ChainVertex::NONE; N];
    for i in 0..len {
        let choice = input.byte();
        let n = input.unit();
        let position = if choice & 1 == 0 || i == 0 {
            input.vector()
        } else if choice & 2 == 0 {
            vertices[i - 1].position
        } else {
            // Along the tangent: grazing.
            let d = input.finite();
            vertices[i - 1].position + vertices[i - 1].tangent_u * d + n * d * 1e-6
        };
        let inner = i > 0 && i + 1 < len;
        if choice & 32 != 0 {
            // On one of the balls, perhaps close to the vertex before, so that there is something to walk on.
            let radius = if choice & 64 != 0 { 1.0 } else { 3.0 };
            let towards = if i > 0 && choice & 128 != 0 {
                vertices[i - 1].position + input.vector() * 0.3
            } else {
                input.vector()
            };
            let n = towards.try_normalize().unwrap_or(Vec3::Z);
            let (u, v) = n.any_orthonormal_pair();
            let alpha = Vec2::new(input.finite().abs(), input.finite().abs());
            let x = ChainVertex {
                position: n * radius,
                position_error: 1e-6,
                geometric_normal: n,
                tangent_u: u,
                tangent_v: v,
                normal: n,
                dn_u: u / radius,
                dn_v: v / radius,
                material: 0,
                ..ChainVertex::NONE
            };
            vertices[i] = if inner {
                x.scattering(choice & 16 != 0, input.finite().abs().max(1e-3), alpha)
            } else {
                x
            };
            continue;
        }
        vertices[i] = if !inner && choice & 4 != 0 {
            ChainVertex::point(position)
        } else if !inner && choice & 8 != 0 {
            ChainVertex::pinned_direction(position, n)
        } else {
            let point = SurfacePoint {
                position,
                position_error: input.finite().abs(),
                geometric_normal: n,
                frame: halflight_kernel::math::Frame::from_normal(input.unit()),
                dp_du: input.vector(),
                dp_dv: input.vector(),
                dn_du: input.vector(),
                dn_dv: input.vector(),
                ..SurfacePoint::ZERO
            };
            let x = ChainVertex::from_surface(&point);
            if inner {
                let alpha = Vec2::new(input.finite().abs(), input.finite().abs());
                x.scattering(choice & 16 != 0, input.finite().abs().max(1e-3), alpha)
            } else {
                x
            }
        };
    }
    // A ball in a ball, all of one material.
    let balls = Spheres::new([(Vec3::ZERO, 1.0, 0), (Vec3::ZERO, 3.0, 0)]);
    let view = SceneView {
        tables: balls.tables(),
        traverse: &balls,
    };
    let mut options = WalkOptions::new(3.0);
    let mut reached = (false, false);
    for form in [0, 1] {
        options.form = form;
        let j = ChainJacobian::new(&vertices, len, form);
        for h in j.h {
            assert!(h.is_finite());
        }
        finite(j.lu.determinant());
        finite(generalized_geometry_term(&vertices, &j));
        finite(measure_by_geometry_terms(&vertices, &j));
        finite(half_vector_measure(&vertices, &j, form));
        assert!(!j.condition().is_nan());
        let mut d = [Mat2::ZERO; N];
        j.lu.row_of_inverse(len - 1, &mut d);
        let (mut weights, mut p) = ([0.0; N], [0.0; N]);
        spectrum_weights(&vertices, len, &mut weights);
        probabilities_b(&vertices, len, &mut p);
        assert!((p.iter().sum::<f32>() - 1.0).abs() < 1e-3);
        for b in 1..len {
            probabilities_c(&vertices, len, b, &mut p);
            assert!((p.iter().sum::<f32>() - 1.0).abs() < 1e-3);
        }
        let mut target = j.h;
        for i in 1..len - 1 {
            let image = image_step(d[i], Vec2::new(input.finite(), 1.0), Vec2::Y);
            let proposal = slope_proposal(&vertices[i], j.h[i], image, weights[i], 0.1);
            target[i] = proposal.sample(Vec2::new(input.finite().abs().fract(), 0.3));
            assert!(target[i].is_finite() && proposal.pdf_slope(target[i]).is_finite());
            let lobe = disk_proposal(&proposal);
            let h = lobe.sample(Vec2::new(0.2, 0.999_999_94));
            assert!(h.is_finite() && lobe.pdf_disk(h).is_finite());
        }
        let m = mutate(&view, &vertices, &j, &target, &options);
        reached.0 |= j.is_regular();
        reached.1 |= m.kind >= mutation_kind::WALK;
        finite(m.forward_factor);
        finite(m.reverse_factor);
        for i in 0..len {
            assert!(m.vertices[i].position.is_finite() && m.reverse_target[i].is_finite());
        }
        finite(prediction_between(&vertices, &m.vertices, len, &j, form == 0).factor);
        let e = explore(&view, &vertices, len, &target, &options);
        for x in &e.vertices {
            assert!(x.position.is_finite());
        }
    }
    reached
}
