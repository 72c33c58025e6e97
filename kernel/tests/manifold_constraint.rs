//! Constraint blocks, J, transfer matrices and the path measure against central differences in f64.

#[path = "common/chains.rs"]
mod chains;
#[path = "common/dense.rs"]
mod dense;
#[path = "common/primitives.rs"]
mod primitives;

use chains::{N, TestChain, chain};
use dense::{block, size};
use glam::{DMat2, Mat2};
use halflight_kernel::manifold::chain::{
    generalized_geometry_term, half_vector_measure, measure_by_geometry_terms,
};
use halflight_kernel::manifold::{ChainJacobian, half_vector_form, vertex_kind};
use primitives::runner;
use proptest::prelude::*;
use std::cell::Cell;

const FORMS: [u32; 2] = [half_vector_form::PROJECTED, half_vector_form::SLOPE];

/// Largest error of a block relative to the largest of its row. The chains have half vectors 0.2 long and longer, edges 0.4
/// and longer and cosines of half vectors above 0.5; `f32` leaves 1e-5 there.
const BLOCK_TOLERANCE: f64 = 3e-5;

fn jacobian(chain: &TestChain, form: u32) -> ChainJacobian<N> {
    ChainJacobian::new(&chain.vertices, chain.len, form)
}

#[test]
fn blocks_are_the_derivatives_of_the_half_vectors() {
    let worst = Cell::new(0.0f64);
    runner(4000)
        .run(&chain(9), |chain| {
            for form in FORMS {
                let j = jacobian(&chain, form);
                prop_assert!(j.valid);
                for i in 0..chain.len {
                    let zero = vec![glam::DVec2::ZERO; chain.len];
                    let h = chain.constraint(i, form, &zero);
                    prop_assert!((j.h[i].as_dvec2() - h).length() < 3e-6 * (1.0 + h.length()));
                    let mut found = vec![(i, j.b[i])];
                    if i > 0 {
                        found.push((i - 1, j.a[i]));
                    }
                    if i + 1 < chain.len {
                        found.push((i + 1, j.c[i]));
                    }
                    let expected: Vec<DMat2> = found
                        .iter()
                        .map(|(at, _)| chain.difference(i, *at, form))
                        .collect();
                    let scale = expected.iter().map(|m| size(*m)).fold(0.0, f64::max);
                    for ((at, m), e) in found.iter().zip(&expected) {
                        let error = size(block(*m) - *e) / scale;
                        worst.set(worst.get().max(error));
                        prop_assert!(
                            error < BLOCK_TOLERANCE,
                            "row {i} by vertex {at}, form {form}: {m:?} instead of {e:?}"
                        );
                    }
                }
            }
            Ok(())
        })
        .unwrap();
    println!("largest error of a block: {:.1e}", worst.get());
}

/// T_i, D_i and det J from the block LU against a dense inverse of the central differences.
#[test]
fn transfer_matrices_inverse_rows_and_determinant() {
    let cases = Cell::new(0);
    runner(3000)
        .run(&chain(9), |chain| {
            for form in FORMS {
                let j = jacobian(&chain, form);
                let exact = chain.jacobian(form);
                let (inverse, ln, _) = exact.inverse();
                let condition = exact.norm() * inverse.norm();
                // Errors of the blocks times the condition: beyond this nothing is left to compare.
                let tolerance = 2.0 * BLOCK_TOLERANCE * condition;
                if !j.is_regular() || tolerance > 0.1 {
                    continue;
                }
                cases.set(cases.get() + 1);
                let last = chain.len - 1;
                let mut found = [Mat2::ZERO; N];
                j.lu.transfer(last, &mut found);
                // T_i = (J^-1)_{i,k} (J^-1)_{k,k}^-1: how vertices follow x_k, whatever its own row.
                let end = inverse.get(last, last).inverse();
                for i in 0..last {
                    let expected = inverse.get(i, last) * end;
                    let scale = inverse.norm() * size(end);
                    let error = size(block(found[i]) - expected) / scale;
                    prop_assert!(error < tolerance, "T_{i} off by {error}");
                }
                j.lu.row_of_inverse(last - 1, &mut found);
                for i in 0..=last {
                    let error = size(block(found[i]) - inverse.get(last - 1, i)) / inverse.norm();
                    prop_assert!(error < tolerance, "D_{i} off by {error}");
                }
                let error = f64::from(j.half_vectors_per_vertex_area().ln_abs()) - ln;
                prop_assert!(error.abs() < 4.0 * tolerance, "ln det off by {error}");
            }
            Ok(())
        })
        .unwrap();
    assert!(
        cases.get() > 4000,
        "only {} chains are regular",
        cases.get()
    );
}

/// Thesis equations 7.4 to 7.6 for reflection, refraction, index-matched vertices, shading normals and all ends: both sides
/// computed by the kernel.
#[test]
fn path_measure_has_two_equal_forms() {
    let (worst, cases) = (Cell::new(0.0f64), Cell::new(0));
    runner(4000)
        .run(&chain(9), |chain| {
            for form in FORMS {
                let j = jacobian(&chain, form);
                if !j.is_regular() || chain.least_cosine() < 0.02 {
                    continue;
                }
                let left = measure_by_geometry_terms(&chain.vertices, &j);
                let right = half_vector_measure(&chain.vertices, &j, form);
                let error = f64::from(left.ln_abs() - right.ln_abs()).abs();
                worst.set(worst.get().max(error));
                cases.set(cases.get() + 1);
                // The pivots' errors cancel between both sides; what remains is that of det C_i at grazing angles.
                prop_assert!(error < 3e-3, "{left:?} {right:?}");
            }
            Ok(())
        })
        .unwrap();
    assert!(cases.get() > 3000);
    println!(
        "identity: ratio 1 within {:.1e}, {} chains",
        worst.get(),
        cases.get()
    );
}

/// The same in absolute terms: |dX/dH| prod G with J from differences and G by definition, both in f64, equal to the
/// kernel's right side.
#[test]
fn path_measure_agrees_with_differences() {
    let cases = Cell::new(0);
    runner(2000)
        .run(&chain(5), |chain| {
            for form in FORMS {
                let j = jacobian(&chain, form);
                let exact = chain.jacobian(form);
                let (inverse, ln, _) = exact.inverse();
                let condition = exact.norm() * inverse.norm();
                if !j.is_regular() || condition > 2e2 || chain.least_cosine() < 0.1 {
                    continue;
                }
                cases.set(cases.get() + 1);
                let mut expected = -ln;
                for i in 1..chain.len {
                    let (p, q) = (&chain.patches[i - 1], &chain.patches[i]);
                    let d = q.origin - p.origin;
                    let cosine = |k: usize, n: glam::DVec3| {
                        if chain.vertices[k].geometric_normal.length_squared() > 0.0 {
                            n.dot(d.normalize()).abs()
                        } else {
                            1.0
                        }
                    };
                    let g = cosine(i - 1, p.n) * cosine(i, q.n) / d.length_squared();
                    expected += g.ln();
                }
                let found = f64::from(half_vector_measure(&chain.vertices, &j, form).ln_abs());
                prop_assert!((found - expected).abs() < 2e-2, "{found} {expected}");
            }
            Ok(())
        })
        .unwrap();
    assert!(cases.get() > 500, "{} cases", cases.get());
}

/// The generalised geometry term of a chain without inner vertices is the geometry term, and a plane mirror only unfolds it.
#[test]
fn generalized_geometry_term_of_a_plane_mirror_is_that_of_the_image() {
    use glam::{Vec2, Vec3};
    use halflight_kernel::manifold::ChainVertex;
    let mut vertices = [ChainVertex::NONE; N];
    vertices[0] = ChainVertex::point(Vec3::new(-1.0, 0.0, 2.0));
    vertices[1] = ChainVertex {
        geometric_normal: Vec3::Z,
        kind: vertex_kind::REFLECTION,
        ..ChainVertex::NONE
    }
    .scattering(false, 1.0, Vec2::ZERO);
    vertices[2] = ChainVertex::point(Vec3::new(1.5, 0.0, 3.0));
    // From (-1, 2) to the origin to (1.5, 3): the law of reflection holds.
    for form in FORMS {
        let j = ChainJacobian::new(&vertices, 3, form);
        let found = generalized_geometry_term(&vertices, &j).value();
        let distance2 = 2.5f32 * 2.5 + 5.0 * 5.0;
        assert!((found * distance2 - 1.0).abs() < 1e-5, "{found}");
    }
    let j = ChainJacobian::new(&vertices, 2, half_vector_form::SLOPE);
    let found = generalized_geometry_term(&vertices, &j).value();
    assert!((found - 2.0 / 5.0f32.sqrt() / 5.0).abs() < 1e-6, "{found}");
}
