//! What edits do to the light of a floor, seen from above, that comes from a diffuse patch alone: the patch has the same radiance in
//! all directions, so that what is turned adds what the target had already, and with energy kept what the source had.

use halflight::film::aov::AovSet;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene;

/// Pixels of a side; the floor is 4 x 4.
const SIZE: usize = 16;

/// The spot lights the patch from below, and nothing else.
const PATCH: &str = r#"
    <integrator type="bdpt"><integer name="max_depth" value="3"/></integrator>
    <sensor type="orthographic"><transform name="to_world"><scale value="2"/><lookat origin="0, 1.2, 0" target="0, 0, 0" up="0, 0, -1"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform><bsdf type="diffuse"/></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="90"/><translate y="1.5"/></transform><bsdf type="diffuse"/></shape>
    <emitter type="spot"><transform name="to_world"><lookat origin="0, 0.5, 0" target="0, 1.5, 0" up="0, 0, 1"/></transform>
        <rgb name="intensity" value="50"/><float name="cutoff_angle" value="12"/></emitter>"#;

/// An edit of what the patch sends into a square of side one around (-1, 0, -1), to around (1, 0, z), `wide` times as wide.
fn edit(wide: f64, more: &str) -> String {
    format!(
        r#"<edit type="retarget"><string name="selection" value="L D^R X"/>
        <transform name="source"><scale x="0.5" y="0.5" z="0.1"/><rotate x="1" angle="-90"/><translate x="-1" z="-1"/></transform>
        <transform name="target"><scale x="{}" y="0.5" z="0.1"/><rotate x="1" angle="-90"/><translate x="1" z="-1"/></transform>{more}</edit>"#,
        0.5 * wide
    )
}

/// The red image, by rows.
fn image(edit: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(
        &path,
        format!("<scene version=\"3.0.0\">{PATCH}{edit}</scene>"),
    )
    .unwrap();
    let scene = build_scene(
        &parse_scene(&path, &[], true).unwrap(),
        &BuildOptions::default(),
    );
    let options = RenderOptions {
        goal: Goal::Samples(256),
        seed: 1,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(&scene.unwrap(), &options, AovSet::NONE).unwrap();
    film.mean().iter().map(|pixel| pixel[0]).collect()
}

/// Sum over a square of the floor around a point, `half` its half sides.
fn sum(image: &[f64], [x, z]: [f64; 2], half: [f64; 2]) -> f64 {
    let place = |i: usize| (i as f64 + 0.5) / SIZE as f64 * 4.0 - 2.0;
    let all = (0..SIZE * SIZE).filter(|i| {
        // Seen from above with -z upwards, and x to the right.
        let (px, pz) = (place(i % SIZE), place(i / SIZE));
        (px - x).abs() < half[0] && (pz - z).abs() < half[1]
    });
    all.map(|i| image[i]).sum()
}

#[test]
fn areas_keep_their_energy_and_leave_the_source_dark() {
    let before = image("");
    let whole: f64 = before.iter().sum();
    let (source, target) = ([-1.0, -1.0], [1.0, -1.0]);
    let half = [0.5, 0.5];
    let [from, to] = [source, target].map(|place| sum(&before, place, half));
    assert!(from > 0.0 && to > 0.0);
    for keep in ["radiance", "energy"] {
        let more = format!(r#"<string name="keep" value="{keep}"/>"#);
        let after = image(&edit(1.0, &more));
        assert!(sum(&after, source, half) < 1e-3 * from, "{keep}");
        // The two squares are mirror images: what the turn adds is what either had, whichever is kept.
        let ratio = sum(&after, target, half) / (from + to);
        assert!((ratio - 1.0).abs() < 0.02, "{keep}: {ratio}");
        let ratio = after.iter().sum::<f64>() / whole;
        assert!((ratio - 1.0).abs() < 0.01, "{keep}: {ratio}");
    }
}

#[test]
fn a_stretched_patch_has_more_light_at_the_same_radiance_or_the_same_light() {
    let before = image("");
    let half = [1.0, 0.5];
    let to = sum(&before, [1.0, -1.0], half);
    let from = sum(&before, [-1.0, -1.0], [0.5, 0.5]);
    let of_radiance = sum(&image(&edit(2.0, "")), [1.0, -1.0], half);
    // All directions have the same radiance, so the target's own light is there twice.
    assert!(
        (of_radiance / (2.0 * to) - 1.0).abs() < 0.02,
        "{of_radiance} {to}"
    );
    let more = r#"<string name="keep" value="energy"/>"#;
    let of_energy = sum(&image(&edit(2.0, more)), [1.0, -1.0], half);
    assert!(
        (of_energy / (to + from) - 1.0).abs() < 0.02,
        "{of_energy} {to} {from}"
    );
    let more = r#"<string name="keep" value="energy"/><float name="intensity" value="0.5"/>"#;
    let dimmed = sum(&image(&edit(2.0, more)), [1.0, -1.0], half);
    assert!(
        (dimmed / (to + 0.5 * from) - 1.0).abs() < 0.02,
        "{dimmed} {to} {from}"
    );
}
