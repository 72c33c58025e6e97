//! The kernel's regularisation functions (`regularize`) over arrays.
//!
//! Functions of the same form share one entry and are told apart by name, which the Python side fixes.

use crate::arrays::{Numbers, array1, map, numbers};
use crate::error::value_error;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::microfacet::Microfacets;
use halflight_kernel::regularize::{bandwidth, bounds, mollifier};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// A bound for roughnesses, per steradian.
#[pyfunction]
fn bound<'py>(
    py: Python<'py>,
    kind: &str,
    masking: u32,
    distribution: u32,
    alpha_u: Numbers<'py>,
    alpha_v: Numbers<'py>,
    eta: Numbers<'py>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let n = alpha_u.as_array().len();
    let (u, v, eta) = (
        numbers(&alpha_u, n)?,
        numbers(&alpha_v, n)?,
        numbers(&eta, n)?,
    );
    let alpha = |i: usize| Vec2::new(u[i], v[i]);
    let values = match kind {
        "reflection" => map(py, n, |i| {
            bounds::reflection_bound(masking, distribution, alpha(i))
        }),
        "refraction" => map(py, n, |i| {
            bounds::refraction_bound(masking, distribution, alpha(i), eta[i])
        }),
        "tight refraction" => map(py, n, |i| {
            bounds::tight_refraction_bound(distribution, u[i], eta[i])
        }),
        other => return Err(value_error(format!("no bound \"{other}\""))),
    };
    Ok(array1(py, values))
}

/// alpha_hat(tau).
#[pyfunction]
fn alpha_hat<'py>(
    py: Python<'py>,
    kind: &str,
    masking: u32,
    distribution: u32,
    tau: Numbers<'py>,
    eta: Numbers<'py>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let n = tau.as_array().len();
    let (tau, eta) = (numbers(&tau, n)?, numbers(&eta, n)?);
    let values = match kind {
        "reflection" => map(py, n, |i| {
            bounds::reflection_alpha(masking, distribution, tau[i])
        }),
        "refraction" => map(py, n, |i| {
            bounds::refraction_alpha(masking, distribution, tau[i], eta[i])
        }),
        "tight refraction" => map(py, n, |i| {
            bounds::tight_refraction_alpha(distribution, tau[i], eta[i])
        }),
        other => return Err(value_error(format!("no bound \"{other}\""))),
    };
    Ok(array1(py, values))
}

/// A bandwidth of sample or iteration n: tau_N, the power law, the geometric law.
#[pyfunction]
fn schedule<'py>(
    py: Python<'py>,
    kind: &str,
    initial: Numbers<'py>,
    n: PyReadonlyArray1<'py, u32>,
    rate: f32,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let count = initial.as_array().len();
    let initial = numbers(&initial, count)?;
    let n = n.as_slice().map_err(value_error)?;
    if n.len() != count {
        return Err(value_error(format!(
            "expected {count} numbers, found {}",
            n.len()
        )));
    }
    let f = match kind {
        "tau" => bandwidth::tau_power_law,
        "power law" => bandwidth::power_law,
        "geometric" => |initial, n, rate| bandwidth::geometric(initial, rate, n),
        other => return Err(value_error(format!("no schedule \"{other}\""))),
    };
    Ok(array1(py, map(py, count, |i| f(initial[i], n[i], rate))))
}

/// Value of a mollifier of bandwidth 1 at distances.
#[pyfunction]
fn mollifier_eval<'py>(
    py: Python<'py>,
    kind: u32,
    dimensions: u32,
    t: Numbers<'py>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let n = t.as_array().len();
    let t = numbers(&t, n)?;
    Ok(array1(
        py,
        map(py, n, |i| mollifier::eval(kind, dimensions, t[i])),
    ))
}

/// Second moment per axis and square norm of a mollifier.
#[pyfunction]
fn mollifier_moments(kind: u32, dimensions: u32) -> (f32, f32) {
    (
        mollifier::second_moment(kind, dimensions),
        mollifier::square_norm(kind, dimensions),
    )
}

/// Microfacet distribution D, per steradian, and Smith's masking G1, at cosines of a normal and of a direction above it.
#[pyfunction]
fn microfacets<'py>(
    py: Python<'py>,
    distribution: u32,
    alpha: Numbers<'py>,
    cosine: Numbers<'py>,
    masking: bool,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let n = alpha.as_array().len();
    let (alpha, cosine) = (numbers(&alpha, n)?, numbers(&cosine, n)?);
    let values = map(py, n, |i| {
        let facets = Microfacets::new(distribution, Vec2::splat(alpha[i]), 1.0);
        let c = cosine[i].clamp(-1.0, 1.0);
        let w = Vec3::new(((1.0 - c) * (1.0 + c)).max(0.0).sqrt(), 0.0, c);
        if masking {
            facets.smith_g1(w, Vec3::Z)
        } else {
            facets.distribution(w)
        }
    });
    Ok(array1(py, values))
}

/// Adds the functions to the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("TAU_MAX", bandwidth::TAU_MAX)?;
    module.add_function(wrap_pyfunction!(bound, module)?)?;
    module.add_function(wrap_pyfunction!(alpha_hat, module)?)?;
    module.add_function(wrap_pyfunction!(schedule, module)?)?;
    module.add_function(wrap_pyfunction!(mollifier_eval, module)?)?;
    module.add_function(wrap_pyfunction!(mollifier_moments, module)?)?;
    module.add_function(wrap_pyfunction!(microfacets, module)?)
}
