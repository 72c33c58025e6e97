//! Paths in stages, with their state in records, are the paths of the loops: the same numbers to the bit.

use halflight::commands::scene_args::build_accel;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::sampler::{AnySampler, sampler_kind};
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::bounce::{Branches, Rays, Shading, bounce, illuminate, shade};
use halflight_kernel::transport::integrator_kind::DIRECT;
use halflight_kernel::transport::staged::PathRecord;
use halflight_kernel::transport::{IntegratorSettings, sample_pixel, staged};
use std::path::Path;

/// Glass, a mask, plastic over rough metal, an area light behind a mask, a point light and the sky.
fn scene(integrator: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0">{integrator}
        <sensor type="perspective"><float name="fov" value="50"/>
            <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            <sampler type="independent"/>
            <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="4"/><translate z="-1"/></transform>
            <bsdf type="twosided"><bsdf type="blendbsdf"><float name="weight" value="0.4"/>
                <bsdf type="roughplastic"/><bsdf type="roughconductor"/></bsdf></bsdf></shape>
        <shape type="sphere"><point name="center" x="-0.8" y="0" z="0"/><float name="radius" value="0.7"/>
            <bsdf type="dielectric"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.6"/><translate x="0.7" z="0.3"/></transform>
            <bsdf type="mask"><float name="opacity" value="0.6"/><bsdf type="diffuse"/></bsdf></shape>
        <shape type="disk"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/>
            <translate x="1" y="1.5"/></transform><emitter type="area"><rgb name="radiance" value="9"/></emitter></shape>
        <emitter type="point"><point name="position" x="2" y="1" z="2"/><rgb name="intensity" value="3"/></emitter>
        <emitter type="constant"><rgb name="radiance" value="0.2"/></emitter></scene>"#
    );
    let parsed = parse_scene_from_str(&text, Path::new("test.xml"), &[], true).expect("a scene");
    build_scene(&parsed, &BuildOptions::default()).expect("tables")
}

/// One path and its present branch, each in a record.
struct StagedPath<'a, T: Traverse> {
    view: &'a SceneView<'a, T>,
    settings: &'a IntegratorSettings,
    path: PathRecord,
    branch: PathRecord,
}

impl<T: Traverse> Shading for StagedPath<'_, T> {
    fn arrive(&mut self) {
        staged::arrive(&self.view.tables, self.settings, &mut self.path);
    }

    fn sample_emitter(&mut self) {
        staged::sample_emitter(&self.view.tables, &mut self.path);
    }

    fn evaluate_emitter(&mut self) {
        staged::evaluate_emitter(&self.view.tables, self.settings, &mut self.path);
    }

    fn sample_bsdf(&mut self) {
        staged::sample_bsdf(&self.view.tables, &mut self.path);
    }

    fn mix_lobes(&mut self) {
        staged::mix_lobes(&self.view.tables, &mut self.path);
    }

    fn scatter(&mut self) {
        staged::scatter(&self.view.tables, self.settings, &mut self.path);
    }
}

impl<T: Traverse> Rays for StagedPath<'_, T> {
    fn trace(&mut self) {
        staged::trace(self.view, &mut self.path);
    }

    fn trace_shadow_rays(&mut self) {
        staged::trace_shadow_ray(self.view, &mut self.path);
    }
}

impl<T: Traverse> Branches for StagedPath<'_, T> {
    fn branch(&mut self) {
        self.branch = self.path;
        let (tables, settings) = (&self.view.tables, self.settings);
        staged::branch(tables, settings, &self.path, &mut self.branch);
    }

    fn follow_branch(&mut self) -> bool {
        let (tables, settings) = (&self.view.tables, self.settings);
        staged::trace(self.view, &mut self.branch);
        staged::follow_branch(tables, settings, &mut self.path, &mut self.branch);
        !self.branch.has_ended()
    }

    fn continue_through_masks(&mut self) {
        staged::continue_through_masks(&self.view.tables, &mut self.path);
    }
}

/// What a host does with one path.
fn in_stages<T: Traverse>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: AnySampler,
    pixel: [u32; 2],
) -> [f32; 3] {
    let path = staged::begin(&view.tables, settings, sampler, pixel);
    let mut driver = StagedPath {
        view,
        settings,
        path,
        branch: path,
    };
    while !driver.path.has_ended() {
        if settings.kind == DIRECT {
            illuminate(&mut driver, &settings.direct);
        } else {
            bounce(&mut driver, shade);
        }
    }
    driver.path.estimate().to_array()
}

fn agrees(integrator: &str) {
    let scene = scene(integrator);
    let accel = build_accel(&scene);
    let tables = scene.tables.view();
    let traverse = accel.traverse(tables);
    let view = SceneView {
        tables,
        traverse: &traverse,
    };
    let mut lit = 0;
    for pixel in 0..24 * 24 {
        let at = [pixel % 24, pixel / 24];
        for kind in [sampler_kind::INDEPENDENT, sampler_kind::SOBOL] {
            let sampler = AnySampler::new(kind, 3, pixel, 1);
            let expected = sample_pixel(&view, &scene.settings, &mut sampler.clone(), at);
            let found = in_stages(&view, &scene.settings, sampler, at);
            assert_eq!(found, expected.to_array(), "pixel {at:?} of {integrator}");
            lit += u32::from(found[0] > 0.0);
        }
    }
    assert!(lit > 500, "{lit}");
}

#[test]
fn path_tracing() {
    agrees(r#"<integrator type="path"><integer name="max_depth" value="12"/></integrator>"#);
    agrees(
        r#"<integrator type="path"><integer name="max_depth" value="3"/><integer name="rr_depth" value="2"/>
        <boolean name="hide_emitters" value="true"/></integrator>"#,
    );
}

#[test]
fn direct_illumination() {
    agrees(
        r#"<integrator type="direct"><integer name="emitter_samples" value="2"/>
        <integer name="bsdf_samples" value="3"/></integrator>"#,
    );
    agrees(
        r#"<integrator type="direct"><integer name="emitter_samples" value="0"/>
        <integer name="bsdf_samples" value="1"/><boolean name="hide_emitters" value="true"/></integrator>"#,
    );
}
