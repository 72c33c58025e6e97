//! Walks on the specular manifold of a scene, over arrays (`kernel::manifold`).
//!
//! A chain begins at a point x_0, scatters at k surfaces and ends at a point x_{k+1}; both ends are pinned. It is first
//! traced: a ray from x_0 towards the first of the given points meets x_1, a ray from there towards the second meets x_2,
//! and so on. Then it walks to the chain whose half vectors have the wanted slopes, zero for a specular connection.

use crate::arrays::{Rows, array1, array2, map, row_count, rows, vec2, vec3};
use crate::error::value_error;
use crate::scene::PyScene;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::fresnel::relative_eta;
use halflight_kernel::bsdf::{Bsdf, mode};
use halflight_kernel::manifold::chain::generalized_geometry_term;
use halflight_kernel::manifold::half_vector_form::SLOPE;
use halflight_kernel::manifold::projection::ray_towards;
use halflight_kernel::manifold::walk::{WalkOptions, walk};
use halflight_kernel::manifold::{ChainJacobian, ChainVertex};
use halflight_kernel::scene::intersect::is_traceable;
use halflight_kernel::scene::surface::checked::checked_surface_at;
use halflight_kernel::scene::{SceneView, Traverse, lobe_kind};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// Most vertices of a chain, ends included.
const CAPACITY: usize = 10;

/// Status of a chain that could not be traced to begin with; the others are the kernel's.
const NO_START: u32 = 5;

/// A chain that was walked to its end.
#[derive(Clone)]
struct Outcome {
    status: u32,
    iterations: u32,
    vertices: [ChainVertex; CAPACITY],
    half_vectors: [Vec2; CAPACITY],
    geometry_term: f32,
}

/// Index of refraction towards the next vertex over that towards the previous one, of a material that transmits.
fn transmitted_index(bsdf: &Bsdf, wi: Vec3) -> Option<f32> {
    (0..bsdf.lobe_count())
        .map(|i| bsdf.lobe(i))
        .find(|lobe| {
            matches!(
                lobe.kind,
                lobe_kind::DIELECTRIC | lobe_kind::ROUGH_DIELECTRIC
            )
        })
        .map(|lobe| relative_eta(wi.z, lobe.eta.x))
}

/// The vertex that a ray from `from` towards `to` meets.
fn trace<T: Traverse>(
    view: &SceneView<'_, T>,
    from: &ChainVertex,
    to: Vec3,
    transmits: bool,
) -> Option<ChainVertex> {
    let ray = ray_towards(from, to);
    if !is_traceable(&ray) {
        return None;
    }
    let hit = view.traverse.closest_hit(&ray);
    let found = checked_surface_at(&view.tables, &ray, &hit);
    if !found.valid {
        return None;
    }
    let wi = found.point.frame.to_local(-ray.direction);
    let eta = if transmits {
        let bsdf = Bsdf::at(&view.tables, &found.point, wi, mode::RADIANCE);
        transmitted_index(&bsdf, wi)?
    } else {
        1.0
    };
    Some(ChainVertex::from_surface(&found.point).scattering(transmits, eta, Vec2::ZERO))
}

/// Traces a chain through `via` and walks it to half vectors of the slopes `targets`.
fn connect<T: Traverse>(
    view: &SceneView<'_, T>,
    ends: [Vec3; 2],
    via: &[[f32; 3]],
    targets: &[[f32; 2]],
    transmits: &[bool],
    options: &WalkOptions,
) -> Outcome {
    let mut out = Outcome {
        status: NO_START,
        iterations: 0,
        vertices: [ChainVertex::NONE; CAPACITY],
        half_vectors: [Vec2::ZERO; CAPACITY],
        geometry_term: 0.0,
    };
    let len = transmits.len() + 2;
    out.vertices[0] = ChainVertex::point(ends[0]);
    out.vertices[len - 1] = ChainVertex::point(ends[1]);
    let mut target = [Vec2::ZERO; CAPACITY];
    for (i, &transmits) in transmits.iter().enumerate() {
        match trace(view, &out.vertices[i], vec3(&via[i]), transmits) {
            Some(vertex) => out.vertices[i + 1] = vertex,
            None => return out,
        }
        target[i + 1] = vec2(&targets[i]);
    }
    let start = ChainJacobian::new(&out.vertices, len, SLOPE);
    let found = walk(view, &out.vertices, &start, &target, options);
    let jacobian = ChainJacobian::new(&found.vertices, len, SLOPE);
    out.status = found.status;
    out.iterations = found.iterations;
    out.vertices = found.vertices;
    out.half_vectors = jacobian.h;
    out.geometry_term = generalized_geometry_term(&found.vertices, &jacobian).value();
    out
}

/// Status, iterations, positions (n k, 3), slopes (n k, 2), generalised geometry terms.
type Walks<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f32>>,
);

#[pymethods]
impl PyScene {
    /// Walks; see `halflight.Scene.walk`.
    fn walk<'py>(
        &self,
        py: Python<'py>,
        start: Rows<'py>,
        via: Rows<'py>,
        end: Rows<'py>,
        targets: Rows<'py>,
        transmits: Vec<bool>,
        max_iterations: u32,
    ) -> PyResult<Walks<'py>> {
        let k = transmits.len();
        if k == 0 || k + 2 > CAPACITY {
            let most = CAPACITY - 2;
            return Err(value_error(format!(
                "a chain scatters 1 to {most} times, not {k}"
            )));
        }
        let n = row_count(&start);
        let (start, end) = (rows::<3>(&start, n)?, rows::<3>(&end, n)?);
        let (via, targets) = (rows::<3>(&via, n * k)?, rows::<2>(&targets, n * k)?);
        let built = self.built(py, None)?;
        let tables = built.scene.tables.view();
        let traverse = built.accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        let options = WalkOptions {
            max_iterations,
            ..WalkOptions::new(tables.info.radius)
        };
        let walks = map(py, n, |i| {
            let ends = [vec3(&start[i]), vec3(&end[i])];
            let own = i * k..(i + 1) * k;
            connect(
                &view,
                ends,
                &via[own.clone()],
                &targets[own],
                &transmits,
                &options,
            )
        });
        let inner = walks.iter().flat_map(|w| &w.vertices[1..=k]);
        let positions = inner.map(|v| v.position.to_array()).collect();
        let slopes = walks.iter().flat_map(|w| &w.half_vectors[1..=k]);
        Ok((
            array1(py, walks.iter().map(|w| w.status).collect()),
            array1(py, walks.iter().map(|w| w.iterations).collect()),
            array2(py, positions)?,
            array2(py, slopes.map(|h| h.to_array()).collect())?,
            array1(py, walks.iter().map(|w| w.geometry_term).collect()),
        ))
    }
}
