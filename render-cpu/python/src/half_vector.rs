//! The kernel's half-vector functions (`manifold::half_vector`, `manifold::step_size`) over arrays.

use crate::arrays::{Numbers, Rows, array1, array2, map, numbers, row_count, rows, vec2, vec3};
use halflight_kernel::manifold::half_vector as kernel;
use halflight_kernel::manifold::step_size;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// Directions, and a number for each.
type Directions<'py, T> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<T>>);

/// Unit half vectors on the side of `n`, and the lengths of wi + eta wo (0 where there is none).
#[pyfunction]
fn half_vector<'py>(
    py: Python<'py>,
    wi: Rows<'py>,
    wo: Rows<'py>,
    eta: Numbers<'py>,
    n: Rows<'py>,
) -> PyResult<Directions<'py, f32>> {
    let count = row_count(&wi);
    let (wi, wo, n) = (rows(&wi, count)?, rows(&wo, count)?, rows(&n, count)?);
    let eta = numbers(&eta, count)?;
    let found = map(py, count, |i| {
        let h = kernel::half_vector(vec3(&wi[i]), vec3(&wo[i]), eta[i], vec3(&n[i]));
        (h.h.to_array(), h.length)
    });
    let (h, length): (Vec<[f32; 3]>, Vec<f32>) = found.into_iter().unzip();
    Ok((array2(py, h)?, array1(py, length)))
}

/// |do / dh| of pairs of directions.
#[pyfunction]
fn solid_angle_per_half_vector<'py>(
    py: Python<'py>,
    wi: Rows<'py>,
    wo: Rows<'py>,
    eta: Numbers<'py>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let count = row_count(&wi);
    let (wi, wo) = (rows(&wi, count)?, rows(&wo, count)?);
    let eta = numbers(&eta, count)?;
    let values = map(py, count, |i| {
        let (wi, wo) = (vec3(&wi[i]), vec3(&wo[i]));
        // The side of the half vector does not matter for the Jacobian.
        kernel::half_vector(wi, wo, eta[i], wi).solid_angle_per_half_vector(wo, eta[i])
    });
    Ok(array1(py, values))
}

/// Directions scattered at microfacets, and whether they exist.
#[pyfunction]
fn scattered<'py>(
    py: Python<'py>,
    wi: Rows<'py>,
    m: Rows<'py>,
    eta: Numbers<'py>,
    transmission: bool,
) -> PyResult<Directions<'py, bool>> {
    let count = row_count(&wi);
    let (wi, m, eta) = (rows(&wi, count)?, rows(&m, count)?, numbers(&eta, count)?);
    let found = map(py, count, |i| {
        let (wi, m) = (vec3(&wi[i]), vec3(&m[i]));
        let out = if transmission {
            kernel::refract(wi, m, eta[i])
        } else {
            kernel::reflect(wi, m)
        };
        (out.wo.to_array(), out.valid)
    });
    let (wo, valid): (Vec<[f32; 3]>, Vec<bool>) = found.into_iter().unzip();
    Ok((array2(py, wo)?, array1(py, valid)))
}

/// Slopes of projected half vectors, or the other way round.
#[pyfunction]
fn change_chart<'py>(
    py: Python<'py>,
    h: Rows<'py>,
    to_slope: bool,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let h = rows(&h, row_count(&h))?;
    let values = map(py, h.len(), |i| {
        let h = vec2(&h[i]);
        if to_slope {
            kernel::slope_of_projected(h).to_array()
        } else {
            kernel::projected_of_slope(h).to_array()
        }
    });
    array2(py, values)
}

/// A function of one number: the Jacobians of the charts, the steps of a mutation.
#[pyfunction]
fn half_vector_function<'py>(
    py: Python<'py>,
    name: &str,
    x: Numbers<'py>,
    gamma: f32,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let x = x.as_array();
    let x = x.as_slice().unwrap_or_default();
    let apply = |f: fn(f32, f32) -> f32| map(py, x.len(), |i| f(x[i], gamma));
    let values = match name {
        "projected_per_half_vector" => apply(|c, _| kernel::projected_per_half_vector(c)),
        "slope_per_half_vector" => apply(|c, _| kernel::slope_per_half_vector(c)),
        "mean_step" => apply(step_size::mean_step),
        "bsdf_deviation" => apply(step_size::bsdf_deviation),
        other => {
            return Err(crate::error::value_error(format!(
                "no function \"{other}\""
            )));
        }
    };
    Ok(array1(py, values))
}

/// Adds the functions to the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(half_vector, module)?)?;
    module.add_function(wrap_pyfunction!(solid_angle_per_half_vector, module)?)?;
    module.add_function(wrap_pyfunction!(scattered, module)?)?;
    module.add_function(wrap_pyfunction!(change_chart, module)?)?;
    module.add_function(wrap_pyfunction!(half_vector_function, module)?)
}
