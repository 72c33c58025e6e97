//! Functions over flat arrays: borrowed from numpy, computed on all threads without the interpreter's lock, and handed to
//! numpy without a copy.
//!
//! Rows of (n, 3) arrays are vectors. All arrays of a call have the same n: the Python side broadcasts.

use crate::error::value_error;
use glam::{Vec2, Vec3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Numbers, one per row.
pub(crate) type Numbers<'py> = PyReadonlyArray1<'py, f32>;
/// Vectors of two or three components, one per row.
pub(crate) type Rows<'py> = PyReadonlyArray2<'py, f32>;

/// Fewest rows for a thread of its own.
const MIN_ROWS: usize = 1024;

/// The contiguous numbers of an array.
pub(crate) fn numbers<'a>(array: &'a Numbers<'_>, rows: usize) -> PyResult<&'a [f32]> {
    let values = array.as_slice().map_err(value_error)?;
    if values.len() == rows {
        Ok(values)
    } else {
        Err(value_error(format!(
            "expected {rows} numbers, found {}",
            values.len()
        )))
    }
}

/// The contiguous rows of an array, `N` numbers each.
pub(crate) fn rows<'a, const N: usize>(
    array: &'a Rows<'_>,
    count: usize,
) -> PyResult<&'a [[f32; N]]> {
    let values = array.as_slice().map_err(value_error)?;
    let (found, rest) = values.as_chunks::<N>();
    if rest.is_empty() && found.len() == count {
        Ok(found)
    } else {
        Err(value_error(format!(
            "expected the shape ({count}, {N}), found {} numbers",
            values.len()
        )))
    }
}

/// How many rows an array has.
pub(crate) fn row_count(array: &Rows<'_>) -> usize {
    array.as_array().nrows()
}

/// A direction of an array.
pub(crate) fn vec3(row: &[f32; 3]) -> Vec3 {
    Vec3::from_array(*row)
}

/// A pair of an array.
pub(crate) fn vec2(row: &[f32; 2]) -> Vec2 {
    Vec2::from_array(*row)
}

/// `f(i)` of every row, on all threads, without the interpreter's lock.
pub(crate) fn map<T: Send>(
    py: Python<'_>,
    rows: usize,
    f: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    py.detach(|| {
        (0..rows)
            .into_par_iter()
            .with_min_len(MIN_ROWS)
            .map(f)
            .collect()
    })
}

/// Numbers as an array of numpy that owns them.
pub(crate) fn array1<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
) -> Bound<'py, PyArray1<T>> {
    values.into_pyarray(py)
}

/// Rows as an array of numpy that owns them.
pub(crate) fn array2<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let count = rows.len();
    // Arrays have no gaps: the numbers stay where they are.
    rows.into_flattened().into_pyarray(py).reshape([count, N])
}
