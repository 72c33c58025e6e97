//! Paths in stages, with their state in records, are the paths of the loops: the same numbers to the bit.

use halflight::commands::scene_args::build_accel;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::sampler::{AnySampler, sampler_kind};
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::integrator_kind::DIRECT;
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

/// What a host does with one path.
fn in_stages<T: Traverse>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: AnySampler,
    pixel: [u32; 2],
) -> [f32; 3] {
    let tables = &view.tables;
    let mut path = staged::begin(tables, settings, sampler, pixel);
    while !path.has_ended() {
        staged::trace(view, &mut path);
        staged::arrive(tables, settings, &mut path);
        let samples = |count| if settings.kind == DIRECT { count } else { 1 };
        for _ in 0..samples(settings.direct.emitter_samples) {
            staged::light(tables, &mut path);
            staged::evaluate(tables, settings, &mut path);
            staged::shadow(view, &mut path);
        }
        for _ in 0..samples(settings.direct.bsdf_samples) {
            staged::sample(tables, &mut path);
            staged::mix(tables, &mut path);
            if settings.kind != DIRECT {
                staged::scatter(tables, settings, &mut path);
                continue;
            }
            let mut branch = path;
            staged::branch(tables, settings, &path, &mut branch);
            while !branch.has_ended() {
                staged::trace(view, &mut branch);
                staged::follow(tables, settings, &mut path, &mut branch);
            }
        }
        if settings.kind == DIRECT {
            staged::continue_through_masks(tables, &mut path);
        }
    }
    path.estimate().to_array()
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
