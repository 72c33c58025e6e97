//! Scenes: read from files, changed in place, rendered.
//!
//! A scene keeps the tree of its file and what it was built from it: tables and ray tracer. Changed parameters take effect
//! at the next render, which builds the tables anew (from the tree and the kept contents of files) and the trees of the ray
//! tracer only if triangles or quadrics moved. Renders under way in other threads keep the tables they began with.

use crate::error::{scene_error, value_error};
use crate::image::PyImage;
use crate::run::run;
use halflight::accel::Accel;
use halflight::film::aov::{Aov, AovSet};
use halflight::image::exr_output::LayeredImage;
use halflight::render::record::{image_metadata, sampler_name};
use halflight::render::{Goal, RenderOptions};
use halflight::scene::build::{
    BuildOptions, Crop, FilmOverride, Scene, build_scene, integrator_settings,
};
use halflight::scene::error::SceneError;
use halflight::scene::xml::{ParsedScene, Value, parse_scene};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A scene that is ready to be rendered, and what it was built with.
#[derive(Clone)]
pub(crate) struct Built {
    /// Tables and settings.
    pub scene: Arc<Scene>,
    /// The ray tracer over them.
    pub accel: Arc<Accel>,
}

/// What changes over the life of a scene.
struct State {
    /// As read.
    parsed: ParsedScene,
    /// Values that differ from the file's.
    changes: BTreeMap<String, Value>,
    /// The newest tables.
    built: Built,
    /// Whether `changes` are not in `built` yet.
    is_stale: bool,
}

/// A scene.
#[pyclass(frozen, module = "halflight._native", name = "Scene")]
pub(crate) struct PyScene {
    path: PathBuf,
    options: BuildOptions,
    keeps_files: bool,
    state: Mutex<State>,
}

/// Reads a scene file; see `halflight.load`.
#[pyfunction]
#[pyo3(signature = (path, defines, size, width, crop, sampler, sensor, strict, keep_files))]
pub(crate) fn load(
    py: Python<'_>,
    path: PathBuf,
    defines: Vec<(String, String)>,
    size: Option<[u32; 2]>,
    width: Option<u32>,
    crop: Option<[u32; 4]>,
    sampler: Option<String>,
    sensor: usize,
    strict: bool,
    keep_files: bool,
) -> PyResult<PyScene> {
    let options = BuildOptions {
        film: FilmOverride {
            size,
            width,
            crop: crop.map(|[x, y, w, h]| Crop {
                offset: [x, y],
                size: [w, h],
            }),
        },
        sampler,
        sensor,
        ..BuildOptions::default()
    };
    let state = py.detach(|| {
        let mut parsed = parse_scene(&path, &defines, strict)?;
        if keep_files {
            parsed = parsed.with_values(&BTreeMap::new())?;
        }
        let built = Built::new(&parsed, &options, None)?;
        Ok(State {
            parsed,
            changes: BTreeMap::new(),
            built,
            is_stale: false,
        })
    });
    let state = state.map_err(|e: SceneError| scene_error(py, &e))?;
    Ok(PyScene {
        path,
        options,
        keeps_files: keep_files,
        state: Mutex::new(state),
    })
}

impl Built {
    /// Builds tables, and the ray tracer unless that of `previous` serves.
    fn new(
        parsed: &ParsedScene,
        options: &BuildOptions,
        previous: Option<&Built>,
    ) -> Result<Built, SceneError> {
        let scene = build_scene(parsed, options)?;
        let same = previous.filter(|built| built.scene.tables.has_geometry_of(&scene.tables));
        let accel = match same {
            Some(built) => built.accel.clone(),
            None => Arc::new(Accel::build(scene.tables.view(), &scene.tables.groups)),
        };
        Ok(Built {
            scene: Arc::new(scene),
            accel,
        })
    }
}

impl State {
    /// The tree with all changes.
    fn current(&self) -> Result<ParsedScene, SceneError> {
        self.parsed.with_values(&self.changes)
    }
}

impl PyScene {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tables that hold all changes, with the integrator of the scene or another one.
    pub(crate) fn built(&self, py: Python<'_>, integrator: Option<String>) -> PyResult<Built> {
        // Without the interpreter's lock: a thread that builds must not wait for one that waits for it.
        let built = py.detach(|| {
            let mut state = self.lock();
            if state.is_stale {
                state.built = Built::new(&state.current()?, &self.options, Some(&state.built))?;
                state.is_stale = false;
            }
            let wanted = BuildOptions {
                integrator,
                ..self.options.clone()
            };
            let radius = state.built.scene.tables.info.radius;
            let (settings, name) = integrator_settings(&state.current()?, &wanted, radius)?;
            if settings != state.built.scene.settings || name != state.built.scene.integrator {
                // A copy only where a render under way holds the tables.
                let scene = Arc::make_mut(&mut state.built.scene);
                scene.settings = settings;
                scene.integrator = name;
            }
            Ok(state.built.clone())
        });
        built.map_err(|e: SceneError| scene_error(py, &e))
    }
}

#[pymethods]
impl PyScene {
    /// Path that the scene was read from.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// What was read but could not be used as written: one line per warning, with file, line and element.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let built = self.built(py, None)?;
        let mut warnings: Vec<String> = self
            .lock()
            .parsed
            .warnings()
            .iter()
            .map(|w| w.to_string())
            .collect();
        warnings.extend(built.scene.warnings.iter().map(|w| w.to_string()));
        warnings.dedup();
        Ok(warnings)
    }

    /// Plugins by kind and name, with how often each occurs.
    #[getter]
    fn plugins(&self, py: Python<'_>) -> PyResult<Vec<(String, usize)>> {
        Ok(self.built(py, None)?.scene.plugins.clone())
    }

    /// Width and height of the image in pixels, of the crop if there is one.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<(u32, u32)> {
        let [width, height] = self.built(py, None)?.scene.tables.camera.crop_size;
        Ok((width, height))
    }

    /// Samples per pixel that the scene asks for.
    #[getter]
    fn spp(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.built(py, None)?.scene.spp)
    }

    /// Seed that the scene asks for.
    #[getter]
    fn seed(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.built(py, None)?.scene.seed)
    }

    /// Name of the integrator that the scene asks for.
    #[getter]
    fn integrator(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.built(py, None)?.scene.integrator.clone())
    }

    /// Name of the sampler: independent or sobol.
    #[getter]
    fn sampler(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(sampler_name(self.built(py, None)?.scene.sampler))
    }

    /// Number of triangles.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.built(py, None)?.scene.tables.triangles.len())
    }

    /// Renders; see `halflight.Scene.render`, which has the checks of combinations.
    #[pyo3(signature = (integrator, spp, time, seed, samples, layers, progress))]
    fn render(
        &self,
        py: Python<'_>,
        integrator: Option<String>,
        spp: Option<u32>,
        time: Option<f64>,
        seed: Option<u32>,
        samples: Option<(u32, u32)>,
        layers: Vec<String>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<PyImage> {
        let built = self.built(py, integrator)?;
        let scene = &built.scene;
        let (first_sample, count) = match samples {
            Some((from, to)) => (from, to.saturating_sub(from)),
            None => (0, spp.unwrap_or(scene.spp)),
        };
        let goal = match time {
            Some(seconds) => Goal::Time(Duration::try_from_secs_f64(seconds).map_err(value_error)?),
            None => Goal::Samples(count),
        };
        // Both cost nothing and make the image comparable and mergeable.
        let mut aovs = AovSet::NONE.with(Aov::Variance).with(Aov::Samples);
        for layer in &layers {
            aovs = aovs.with(layer.parse().map_err(value_error)?);
        }
        let options = RenderOptions {
            goal,
            seed: seed.unwrap_or(scene.seed),
            first_sample,
            adaptive: false,
        };
        let run = run(py, scene, &built.accel, &options, aovs, progress.as_ref())?;
        let image = py.detach(|| {
            let metadata = image_metadata(&self.path, scene, &run.film, &options, &run.state);
            LayeredImage::from_film(&run.film, scene.tables.camera.film_size, metadata)
        });
        PyImage::from_film(py, image, run.interrupted)
    }

    /// Names and values of the parameters, with changes that were made.
    fn values(&self, py: Python<'_>) -> PyResult<Vec<(String, Py<PyAny>)>> {
        let state = self.lock();
        let named = state.parsed.values().into_iter().map(|entry| {
            let value = state.changes.get(&entry.name).unwrap_or(&entry.value);
            Ok((entry.name, crate::parameters::to_python(py, value)?))
        });
        named.collect()
    }

    /// Changes parameters, all or none; the next render has them.
    fn change(&self, changes: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<()> {
        let mut state = self.lock();
        let known: BTreeMap<String, Value> = state
            .parsed
            .values()
            .into_iter()
            .map(|entry| (entry.name, entry.value))
            .collect();
        let mut converted = Vec::with_capacity(changes.len());
        for (name, value) in changes {
            let Some(old) = known.get(&name) else {
                return Err(crate::parameters::unknown(&name, known.keys()));
            };
            let new = crate::parameters::from_python(&name, old, &value)?;
            converted.push((name, new));
        }
        state.changes.extend(converted);
        state.is_stale = true;
        Ok(())
    }

    /// Whether contents of files are kept in memory for changes of parameters.
    #[getter]
    fn keeps_files(&self) -> bool {
        self.keeps_files
    }
}
