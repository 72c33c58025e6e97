//! Materials at one point, over arrays of directions.
//!
//! Directions are in the local frame, z the shading normal, and point away from the surface; wi is the known one. The
//! material is built as in a scene (it is one: the material ball of the previews), so that parameters mean what they mean
//! there, and looked up at one place of the texture square.

use crate::arrays::{Numbers, Rows, array1, array2, map, numbers, row_count, rows, vec2, vec3};
use crate::error::{file_error, scene_error, value_error};
use glam::{Vec2, Vec3};
use halflight::material::preview::{AnyError, Preview};
use halflight::material::source::{Source, SourceError, find};
use halflight::scene::error::SceneError;
use halflight_kernel::bsdf::{Bsdf, local_beckmann_roughness, mode};
use halflight_kernel::math::Frame;
use halflight_kernel::regularize::regularized_bsdf;
use halflight_kernel::scene::{NONE, SurfacePoint};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A material at one point.
#[pyclass(frozen, module = "halflight._native", name = "Bsdf")]
pub(crate) struct PyBsdf {
    name: String,
    preview: Preview,
    uv: Vec2,
    mode: u32,
}

fn build(py: Python<'_>, source: &Source, uv: [f32; 2], importance: bool) -> PyResult<PyBsdf> {
    let preview = py.detach(|| Preview::new(source, 1));
    let preview = preview.map_err(|e: AnyError| match e.downcast::<SceneError>() {
        Ok(cause) => scene_error(py, &cause),
        Err(other) => value_error(other),
    })?;
    if let Some(warning) = preview.scene.warnings.first() {
        // A misspelt parameter is a mistake here, where nobody reads warnings.
        return Err(value_error(format!(
            "{}: {}",
            warning.element, warning.message
        )));
    }
    Ok(PyBsdf {
        name: source.name.clone(),
        preview,
        uv: vec2(&uv),
        mode: if importance {
            mode::IMPORTANCE
        } else {
            mode::RADIANCE
        },
    })
}

impl PyBsdf {
    fn point(&self) -> SurfacePoint {
        SurfacePoint {
            position: Vec3::ZERO,
            position_error: 0.0,
            geometric_normal: Vec3::Z,
            frame: Frame::LOCAL,
            uv: self.uv,
            barycentric: Vec2::ZERO,
            dp_du: Vec3::X,
            dp_dv: Vec3::Y,
            dn_du: Vec3::ZERO,
            dn_dv: Vec3::ZERO,
            shape: 0,
            primitive: NONE,
            instance: 0,
            material: self.preview.material,
            emitter: NONE,
        }
    }

    /// `f(data, bsdf, wi)` of every row.
    fn over<T: Send>(
        &self,
        py: Python<'_>,
        wi: &[[f32; 3]],
        f: impl Fn(&[f32], &Bsdf, Vec3, usize) -> T + Sync + Send,
    ) -> Vec<T> {
        let tables = self.preview.scene.tables.view();
        let point = self.point();
        map(py, wi.len(), |i| {
            let wi = vec3(&wi[i]);
            let bsdf = Bsdf::at(&tables, &point, wi, self.mode);
            f(tables.data, &bsdf, wi, i)
        })
    }
}

/// Values of a BSDF with a cosine, and densities.
type EvalPdf<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f32>>);
/// Directions, weights, densities, relative indices, events.
type Samples<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<u32>>,
);

#[pymethods]
impl PyBsdf {
    /// A BSDF of XML text; relative files are sought beside `file`.
    #[staticmethod]
    fn from_xml(
        py: Python<'_>,
        xml: String,
        name: String,
        file: PathBuf,
        uv: [f32; 2],
        importance: bool,
    ) -> PyResult<PyBsdf> {
        let source = Source {
            name,
            bsdf: xml,
            definitions: String::new(),
            version: "3.0.0".to_owned(),
            file,
        };
        build(py, &source, uv, importance)
    }

    /// A BSDF of a scene file or a measurement, an example or a metal.
    #[staticmethod]
    fn find(
        py: Python<'_>,
        name: &str,
        id: Option<&str>,
        uv: [f32; 2],
        importance: bool,
    ) -> PyResult<PyBsdf> {
        let source = find(name, id).map_err(|e| match e {
            SourceError::Io { .. } => file_error(e),
            other => value_error(other),
        })?;
        build(py, &source, uv, importance)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    fn eval_cosine_pdf<'py>(
        &self,
        py: Python<'py>,
        wi: Rows<'py>,
        wo: Rows<'py>,
    ) -> PyResult<EvalPdf<'py>> {
        let n = row_count(&wi);
        let (wi, wo) = (rows(&wi, n)?, rows(&wo, n)?);
        let values = self.over(py, wi, |data, bsdf, wi, i| {
            let (f, pdf) = bsdf.eval_cosine_pdf(data, wi, vec3(&wo[i]));
            (f.to_array(), pdf)
        });
        let (f, pdf): (Vec<[f32; 3]>, Vec<f32>) = values.into_iter().unzip();
        Ok((array2(py, f)?, array1(py, pdf)))
    }

    fn regularized_eval_cosine_pdf<'py>(
        &self,
        py: Python<'py>,
        wi: Rows<'py>,
        wo: Rows<'py>,
        tau: Numbers<'py>,
    ) -> PyResult<EvalPdf<'py>> {
        let n = row_count(&wi);
        let (wi, wo, tau) = (rows(&wi, n)?, rows(&wo, n)?, numbers(&tau, n)?);
        let values = self.over(py, wi, |data, bsdf, wi, i| {
            let (f, pdf) =
                regularized_bsdf::mixture_eval_cosine_pdf(bsdf, data, wi, vec3(&wo[i]), tau[i]);
            (f.to_array(), pdf)
        });
        let (f, pdf): (Vec<[f32; 3]>, Vec<f32>) = values.into_iter().unzip();
        Ok((array2(py, f)?, array1(py, pdf)))
    }

    fn sample<'py>(&self, py: Python<'py>, wi: Rows<'py>, u: Rows<'py>) -> PyResult<Samples<'py>> {
        let n = row_count(&wi);
        let (wi, u) = (rows(&wi, n)?, rows::<3>(&u, n)?);
        let samples = self.over(py, wi, |data, bsdf, wi, i| {
            let [u1, u2, u3] = u[i];
            bsdf.sample(data, wi, u1, Vec2::new(u2, u3))
        });
        let wo = samples.iter().map(|s| s.wo.to_array()).collect();
        let weight = samples.iter().map(|s| s.weight.to_array()).collect();
        Ok((
            array2(py, wo)?,
            array2(py, weight)?,
            array1(py, samples.iter().map(|s| s.pdf).collect()),
            array1(py, samples.iter().map(|s| s.eta).collect()),
            array1(py, samples.iter().map(|s| s.event).collect()),
        ))
    }

    fn local_roughness<'py>(
        &self,
        py: Python<'py>,
        wi: Rows<'py>,
        wo: Rows<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let n = row_count(&wi);
        let (wi, wo) = (rows(&wi, n)?, rows(&wo, n)?);
        let values = self.over(py, wi, |data, bsdf, wi, i| {
            local_beckmann_roughness(bsdf, data, wi, vec3(&wo[i]))
        });
        Ok(array1(py, values))
    }

    fn bound<'py>(
        &self,
        py: Python<'py>,
        wi: Rows<'py>,
        transmission: bool,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let wi = rows(&wi, row_count(&wi))?;
        let values = self.over(py, wi, |_, bsdf, _, _| {
            regularized_bsdf::mixture_bound(bsdf, transmission)
        });
        Ok(array1(py, values))
    }
}
