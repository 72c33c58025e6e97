//! Comparisons of two images: the metrics of `halflight compare`, and maps of the error.

use crate::error::{file_error, value_error};
use crate::image::{PyImage, exr_of_array};
use halflight::compare::comparison::{Comparison, ErrorMap, Metric, Options};
use halflight::image::{ExrImage, read_exr};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// How two images differ.
#[pyclass(frozen, module = "halflight", name = "Comparison")]
pub(crate) struct PyComparison {
    inner: Comparison,
}

/// An image in one of the forms that Python has them in, and what to call it in messages.
fn image(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<(String, ExrImage)> {
    if let Ok(image) = argument.cast::<PyImage>() {
        return Ok((name.to_owned(), image.get().to_exr(argument.py())?));
    }
    if let Ok(path) = argument.extract::<PathBuf>() {
        let image = argument.py().detach(|| read_exr(&path));
        return Ok((path.display().to_string(), image.map_err(file_error)?));
    }
    Ok((name.to_owned(), exr_of_array(argument)?))
}

/// Compares an image with a reference.
///
/// `a` and `b` are images, paths of OpenEXR files, or arrays of the shape (height, width, 3), linear sRGB. Where both
/// carry variances (rendered images do), a z-test says whether they estimate the same radiance; `reference_spp` and
/// `reference_runs` tell it what the reference's file does not: samples per pixel, and independent runs behind its
/// variance.
///
/// Raises ValueError when sizes differ or a channel is missing, OSError when a file cannot be read.
#[pyfunction]
#[pyo3(signature = (a, b, *, reference_spp=None, reference_runs=None))]
pub(crate) fn compare(
    py: Python<'_>,
    a: &Bound<'_, PyAny>,
    b: &Bound<'_, PyAny>,
    reference_spp: Option<f64>,
    reference_runs: Option<u32>,
) -> PyResult<PyComparison> {
    let (name_a, image_a) = image(a, "the image")?;
    let (name_b, image_b) = image(b, "the reference")?;
    let options = Options {
        reference_runs,
        reference_spp,
        ..Options::default()
    };
    let inner = py
        .detach(|| Comparison::new((&name_a, &image_a), (&name_b, &image_b), &options))
        .map_err(value_error)?;
    Ok(PyComparison { inner })
}

#[pymethods]
impl PyComparison {
    /// All metrics that could be computed, by the names of the command line.
    #[getter]
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (metric, value) in &self.inner.values {
            dict.set_item(metric.name(), value)?;
        }
        Ok(dict)
    }

    /// A metric by its name: mse, relative-mse, residual-rms, psnr, ssim, flip, hdr-flip, z-test, non-finite.
    ///
    /// Raises ValueError for another name, KeyError for one that these images do not have.
    fn __getitem__(&self, name: &str) -> PyResult<f64> {
        let metric: Metric = name.parse().map_err(value_error)?;
        self.inner.value(metric).ok_or_else(|| {
            pyo3::exceptions::PyKeyError::new_err(format!("no {name}: {}", self.inner.no_ztest))
        })
    }

    /// Whether the z-test takes both for estimates of the same radiance; None where there is none.
    #[getter]
    fn passes(&self) -> Option<bool> {
        self.inner.ztest.as_ref().map(|outcome| outcome.passes())
    }

    /// Mean of z over pixels and channels, far from zero for a bias; None without a z-test.
    #[getter]
    fn mean_z(&self) -> Option<f64> {
        self.inner.ztest.as_ref().map(|outcome| outcome.mean_z)
    }

    /// The error of each pixel: float64 of the shape (height, width), not finite where the images are not.
    ///
    /// `kind` is flip, hdr-flip (0 to 1 both), or relative: |a - b| / (|b| + 0.01), mean of the channels.
    ///
    /// Raises ValueError for another kind.
    #[pyo3(signature = (kind="flip"))]
    fn error_map<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let kind = match kind {
            "flip" => ErrorMap::Flip,
            "hdr-flip" => ErrorMap::HdrFlip,
            "relative" => ErrorMap::Relative,
            other => {
                return Err(value_error(format!(
                    "no error map \"{other}\"; there are flip, hdr-flip and relative"
                )));
            }
        };
        let map = py.detach(|| self.inner.error_map(kind));
        map.into_pyarray(py)
            .reshape([self.inner.height, self.inner.width])
    }

    fn __repr__(&self) -> String {
        let values = self.inner.values.iter();
        let values: Vec<String> = values.map(|(m, v)| format!("{m} {v:.6}")).collect();
        format!("<halflight.Comparison {}>", values.join(", "))
    }
}
