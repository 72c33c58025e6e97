//! Every mutation on scenes with poles: grazing angles, surfaces that coincide, indices near one, roughness near zero, edges of no
//! length, normals far off their triangles. Nothing panics, no number is infinite or a NaN, no path without light becomes the state.
//! `HALFLIGHT_HOSTILE_SCENES=N` makes more of the random ones, and the fuzz target `mutations` all that it finds.

use crate::brightness::{SKY, camera};
use crate::hostile_scenes::{self, MESH};
use crate::scenes::{LAMP, NamedFile, PINHOLE, faceted_sphere, room, scene, sky, with_view};
use halflight_kernel::transport::markov::algorithm::StepRecord;
use halflight_kernel::transport::markov::{ChainAlgorithm, Splat, VeachChains};
use halflight_kernel::transport::settings::{
    ChainSettings, IntegratorSettings, half_vector_flag, integrator_kind,
};

fn ball(material: &str, center: &str) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" value="{center}"/><float name="radius" value="0.4"/>{material}</shape>"#
    )
}

fn glass(index: f32) -> String {
    format!(r#"<bsdf type="dielectric"><float name="int_ior" value="{index}"/></bsdf>"#)
}

fn rough(alpha: f32, index: f32) -> String {
    format!(
        r#"<bsdf type="roughdielectric"><float name="alpha" value="{alpha}"/><float name="int_ior" value="{index}"/></bsdf>"#
    )
}

fn metal(alpha: f32) -> String {
    format!(r#"<bsdf type="roughconductor"><float name="alpha" value="{alpha}"/></bsdf>"#)
}

/// A sheet that lies in the floor, and one that the camera sees from the edge.
const SHEETS: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.7"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha" value="0.05"/></bsdf></bsdf></shape>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><translate y="0.9999"/></transform>
    <bsdf type="roughdielectric"><float name="alpha" value="0.02"/></bsdf></shape>"#;

const FACETS: &str = r#"<shape type="obj"><string name="filename" value="sphere.obj"/>
    <transform name="to_world"><scale value="0.5"/><translate y="0.5"/></transform>
    <bsdf type="roughplastic"><float name="alpha" value="0.01"/></bsdf></shape>"#;

fn scenes() -> Vec<(&'static str, String)> {
    let thin = camera(
        "thinlens",
        r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="0.5"/>"#,
    );
    vec![
        (
            "indices near one",
            [
                PINHOLE,
                &room(&metal(0.3)),
                LAMP,
                &ball(&glass(1.0004), "0.3, 0.5, 0"),
                &ball(&rough(0.1, 1.002), "-0.5, 0.5, 0"),
            ]
            .concat(),
        ),
        (
            "roughness near zero",
            [
                PINHOLE,
                &room(&metal(0.0002)),
                LAMP,
                &ball(&rough(0.0003, 1.5), "0, 0.5, 0.5"),
            ]
            .concat(),
        ),
        (
            "sheets that coincide, and grazing ones",
            [PINHOLE, &room(&metal(0.2)), LAMP, SHEETS].concat(),
        ),
        (
            "facets under a sky, through a thin lens",
            [&thin, &room(&metal(0.05)), SKY, FACETS].concat(),
        ),
    ]
}

fn last_step<A: ChainAlgorithm>(_: &A, chain: &A::Chain) -> Option<StepRecord> {
    A::last_step(chain)
}

#[test]
fn mutations_are_total() {
    let files: &[NamedFile<'_>] = &[("sky.exr", &sky), ("sphere.obj", &faceted_sphere)];
    let original = half_vector_flag::ORIGINAL;
    let variants = [
        (0.0, 1.0, 0, 0.2),
        (0.0, 1.0, original, 0.2),
        (0.0, 1.0, original | half_vector_flag::UNSTRATIFIED, 3.0),
        (
            0.0,
            1.0,
            half_vector_flag::PROJECTED | half_vector_flag::GLOBAL_ROUGHNESS,
            1.0,
        ),
        (1.0, 0.0, 0, 0.2),
    ];
    for (what, content) in scenes() {
        let scene = scene(&content, files);
        let mut moved = 0;
        with_view(&scene, |view| {
            for (manifold, half_vector, flags, step) in variants {
                let settings = IntegratorSettings {
                    kind: integrator_kind::VEACH_MLT,
                    chains: ChainSettings {
                        bidirectional_weight: 0.25,
                        lens_weight: 0.0,
                        caustic_weight: 0.0,
                        multi_chain_weight: 0.0,
                        manifold_weight: manifold,
                        half_vector_weight: half_vector,
                        half_vector_flags: flags,
                        half_vector_step: step,
                        ..ChainSettings::DEFAULT
                    },
                    ..scene.settings
                };
                let chains = VeachChains::new(view, &settings, 2, 7, 0);
                for candidate in 0..400 {
                    let (mut member, mut lit) = (0, None);
                    chains.candidate_weights(candidate, &mut |weight| {
                        if weight > 0.0 && weight.is_finite() {
                            lit = Some(member);
                        }
                        member += 1;
                    });
                    let Some(member) = lit else { continue };
                    let mut chain = chains.start(candidate, member, candidate);
                    let mut check = |splat: Splat| {
                        let is_light = splat.value.is_finite() && splat.value.max_element() > 0.0;
                        assert!(is_light && splat.film.is_finite(), "{what}: {splat:?}");
                    };
                    for _ in 0..24 {
                        chains.step(&mut chain, 1.0, &mut check);
                        let acceptance =
                            last_step(&chains, &chain).map_or(0.0, |last| last.acceptance);
                        assert!((0.0..=1.0).contains(&acceptance), "{what}: {acceptance}");
                        moved += u32::from(acceptance > 0.0);
                    }
                    chains.finish(&mut chain, 1.0, &mut check);
                }
            }
        });
        println!("{what}: {moved} proposals with light");
        assert!(moved > 200, "{what} shows nothing");
    }
}

#[test]
fn random_scenes_are_total() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(MESH.0), MESH.1).unwrap();
    let scenes: u64 = std::env::var("HALFLIGHT_HOSTILE_SCENES")
        .map_or(150, |text| text.parse().expect("a number of scenes"));
    let (mut chains, mut proposals, mut walks) = (0, 0, 0);
    for scene in 0..scenes {
        let numbers = |i: u32| hash(scene as u32, i).to_le_bytes();
        let bytes: Vec<u8> = (0..40).flat_map(numbers).collect();
        let reached = hostile_scenes::check(&bytes, folder.path());
        chains += reached.chains;
        proposals += reached.proposals;
        walks += reached.walks;
    }
    println!("{scenes} scenes: {chains} chains, {proposals} proposals with light, {walks} walks");
    let least = scenes as u32;
    assert!(chains > 10 * least && proposals > 20 * least && walks > 10 * scenes);
}

/// 32 bits that belong to two numbers.
fn hash(a: u32, b: u32) -> u32 {
    halflight_kernel::sampler::mix(halflight_kernel::sampler::mix(a).wrapping_add(b))
}
