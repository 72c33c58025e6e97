//! Spectra to colours: against Mitsuba 3, and against what must hold.

use halflight::scene::color::{
    ColorUse, Illuminant, blackbody_to_srgb, linear_to_srgb, planck, samples_to_srgb,
    spectrum_to_srgb, srgb_to_linear,
};
use halflight::scene::ior;
use halflight::scene::xml::{Object, parse_scene_from_str};
use proptest::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// A scene with one bsdf that holds the given elements.
fn bsdf(elements: &str) -> Arc<Object> {
    let text = format!("<scene version=\"3.0.0\"><bsdf type=\"t\">{elements}</bsdf></scene>");
    let scene = parse_scene_from_str(&text, Path::new("scene.xml"), &[], false).expect("parses");
    let child = scene.root.children().next().expect("a bsdf");
    child.object.clone()
}

fn colour(element: &str, usage: ColorUse) -> [f32; 3] {
    bsdf(element)
        .opt_rgb("c", usage)
        .expect("converts")
        .expect("is there")
}

fn assert_near(found: [f32; 3], wanted: [f32; 3], tolerance: f32, what: &str) {
    for i in 0..3 {
        let error = (found[i] - wanted[i]).abs() / wanted[i].abs().max(1.0);
        assert!(error <= tolerance, "{what}: {found:?}, wanted {wanted:?}");
    }
}

#[test]
fn spectra_agree_with_mitsuba() {
    let mut rows = 0;
    for line in include_str!("oracle/spectra.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
    {
        let mut fields = line.split('|');
        let mut next = || fields.next().expect("a field");
        let usage = match next() {
            "Reflectance" => ColorUse::Reflectance,
            "Emission" => ColorUse::Emission,
            "Unbounded" => ColorUse::Unbounded,
            other => panic!("unknown use {other}"),
        };
        let samples = next();
        let wanted: Vec<f32> = next()
            .split(',')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let element = format!("<spectrum name=\"c\" value=\"{samples}\"/>");
        assert_near(
            colour(&element, usage),
            [wanted[0], wanted[1], wanted[2]],
            1e-4,
            line,
        );
        rows += 1;
    }
    assert_eq!(rows, 36);
}

#[test]
fn plain_numbers_and_triplets_are_taken_as_they_are() {
    let reflectance = |element| colour(element, ColorUse::Reflectance);
    assert_eq!(reflectance("<float name=\"c\" value=\"0.3\"/>"), [0.3; 3]);
    assert_eq!(reflectance("<integer name=\"c\" value=\"1\"/>"), [1.0; 3]);
    assert_eq!(
        reflectance("<rgb name=\"c\" value=\"0.1, 0.2 0.3\"/>"),
        [0.1, 0.2, 0.3]
    );
    assert_eq!(reflectance("<rgb name=\"c\" value=\"0.4\"/>"), [0.4; 3]);
    assert_eq!(
        reflectance("<rgb name=\"c\" value=\"#ff0033\"/>"),
        [1.0, 0.0, 0.2]
    );
    assert_eq!(
        reflectance("<spectrum name=\"c\" value=\"0.5\"/>"),
        [0.5; 3]
    );
    assert_eq!(
        reflectance("<spectrum name=\"c\" value=\"0.5, 0.6, 0.7\"/>"),
        [0.5, 0.6, 0.7]
    );
    let linear = srgb_to_linear(0.5) as f32;
    assert_eq!(
        reflectance("<srgb name=\"c\" value=\"0.5 0 1\"/>"),
        [linear, 0.0, 1.0]
    );
    assert_near(
        reflectance("<srgb name=\"c\" value=\"#8000ff\"/>"),
        [0.21586, 0.0, 1.0],
        1e-5,
        "hexadecimal",
    );
}

#[test]
fn flat_emission_has_the_colour_of_equal_energy() {
    // Mitsuba 3.9.1: <spectrum name="radiance" value="2.5"/>.
    let found = colour("<spectrum name=\"c\" value=\"2.5\"/>", ColorUse::Emission);
    assert_near(found, [3.01198, 2.37073, 2.27229], 1e-5, "spectrum");
    assert_eq!(
        colour("<float name=\"c\" value=\"3\"/>", ColorUse::Emission),
        [3.0; 3]
    );
}

#[test]
fn typed_spectra_are_colours() {
    let emission = |element| colour(element, ColorUse::Emission);
    let uniform =
        "<spectrum type=\"uniform\" name=\"c\"><float name=\"value\" value=\"2\"/></spectrum>";
    assert_eq!(emission(uniform), [2.0; 3]);
    assert_eq!(emission("<spectrum type=\"d65\" name=\"c\"/>"), [1.0; 3]);
    let listed = emission("<spectrum name=\"c\" value=\"400:0, 500:8, 600:15.6, 700:18.4\"/>");
    let regular = "<spectrum type=\"regular\" name=\"c\"><float name=\"wavelength_min\" value=\"400\"/>\
        <float name=\"wavelength_max\" value=\"700\"/><string name=\"values\" value=\"0, 8, 15.6, 18.4\"/></spectrum>";
    assert_near(emission(regular), listed, 1e-6, "regular");
    let irregular = "<spectrum type=\"irregular\" name=\"c\">\
        <string name=\"wavelengths\" value=\"400 500 600 700\"/>\
        <string name=\"values\" value=\"0 8 15.6 18.4\"/></spectrum>";
    assert_near(emission(irregular), listed, 1e-6, "irregular");
    let typed = "<spectrum type=\"blackbody\" name=\"c\"><float name=\"temperature\" value=\"4000\"/></spectrum>";
    let old = "<blackbody name=\"c\" temperature=\"4000K\" scale=\"1\"/>";
    assert_eq!(emission(typed), emission(old));
}

#[test]
fn black_bodies_shine_as_planck_says() {
    // Wien: the peak of 5000 K is at 2.897772e-3 m K / T = 579.554 nm; Stefan and Boltzmann: the integral over all
    // wavelengths is sigma T^4 / pi.
    let peak = 579.5544;
    assert!(planck(peak, 5000.0) > planck(peak - 0.1, 5000.0));
    assert!(planck(peak, 5000.0) > planck(peak + 0.1, 5000.0));
    let integral: f64 = (1..100_000).map(|i| planck(f64::from(i), 5000.0)).sum();
    let wanted = 5.670374419e-8 * 5000.0f64.powi(4) / std::f64::consts::PI;
    assert!(
        (integral / wanted - 1.0).abs() < 1e-3,
        "{integral} {wanted}"
    );
    // Warm light is red, cold light is blue; 6500 K is nearly white.
    let [r, _, b] = blackbody_to_srgb(3000.0);
    assert!(r > 2.0 * b);
    let [r, g, b] = blackbody_to_srgb(6500.0);
    assert!(
        (r / g - 1.0).abs() < 0.07 && (b / g - 1.0).abs() < 0.07,
        "{r} {g} {b}"
    );
    let [r, _, b] = blackbody_to_srgb(12000.0);
    assert!(b > 1.2 * r);
}

#[test]
fn out_of_range_colours_are_clamped_with_a_warning() {
    let text = "<scene version=\"3.0.0\"><bsdf type=\"t\">\n<rgb name=\"c\" value=\"1.5 -1 0.5\"/></bsdf></scene>";
    let scene = parse_scene_from_str(text, Path::new("scene.xml"), &[], false).expect("parses");
    let child = scene.root.children().next().expect("a bsdf");
    let found = child
        .object
        .opt_rgb("c", ColorUse::Reflectance)
        .expect("converts");
    assert_eq!(found, Some([1.0, 0.0, 0.5]));
    let warnings = scene.warnings();
    assert_eq!(warnings.len(), 1);
    assert_eq!(
        warnings[0].to_string(),
        "scene.xml:2:1: <rgb name=\"c\">: the colour (1.5, -1, 0.5) is clamped to [0, 1]"
    );
    let strict = parse_scene_from_str(text, Path::new("scene.xml"), &[], true).expect("parses");
    let child = strict.root.children().next().expect("a bsdf");
    assert!(child.object.opt_rgb("c", ColorUse::Reflectance).is_err());
}

#[test]
fn spectrum_files_are_read_and_bad_ones_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene_file = folder.path().join("scene.xml");
    let text = "<scene version=\"0.6.0\"><bsdf type=\"t\"><spectrum name=\"c\" filename=\"s.spd\"/></bsdf></scene>";
    std::fs::write(&scene_file, text).expect("writes");
    let read = |content: &str| {
        std::fs::write(folder.path().join("s.spd"), content).expect("writes");
        let scene = halflight::scene::xml::parse_scene(&scene_file, &[], true).expect("parses");
        let child = scene.root.children().next().expect("a bsdf");
        child.object.opt_rgb("c", ColorUse::Reflectance)
    };
    let found = read("# measured\n400 0.1\n700 0.9\n").expect("reads");
    assert_eq!(
        found,
        Some(colour(
            "<spectrum name=\"c\" value=\"400:0.1, 700:0.9\"/>",
            ColorUse::Reflectance
        ))
    );
    for (content, wanted) in [
        (
            "400 0.1\n700 x\n",
            "s.spd:2: expected a number, found \"x\"",
        ),
        (
            "400 0.1\n700 1 2\n",
            "s.spd:2: expected a wavelength and a value",
        ),
        (
            "700 0.1\n400 0.2\n",
            "s.spd: the wavelengths must increase, but 400 follows 700",
        ),
        ("", "s.spd: a spectrum needs two or more wavelengths"),
    ] {
        let message = read(content).expect_err("is bad").to_string();
        assert!(message.ends_with(wanted), "{message}");
    }
}

#[test]
fn indices_of_refraction_have_names() {
    let index = |elements: &str| ior::get_dielectric(&bsdf(elements), "int_ior", 1.5046);
    assert_eq!(index("").expect("default"), 1.5046);
    assert_eq!(
        index("<string name=\"int_ior\" value=\"Diamond\"/>").expect("named"),
        2.419
    );
    assert_eq!(
        index("<float name=\"intIOR\" value=\"1.7\"/>").expect("number"),
        1.7
    );
    let message = index("<string name=\"int_ior\" value=\"dimond\"/>")
        .expect_err("misspelt")
        .to_string();
    assert!(
        message.ends_with("no dielectric is called \"dimond\"; did you mean \"diamond\"?"),
        "{message}"
    );
    assert!(index("<float name=\"int_ior\" value=\"0\"/>").is_err());

    let conductor = |elements: &str| ior::get_conductor(&bsdf(elements));
    assert_eq!(
        conductor("").expect("default"),
        ior::Conductor::PERFECT_MIRROR
    );
    let copper = conductor("<string name=\"material\" value=\"Cu\"/>").expect("named");
    assert_eq!(copper.k, [3.913262, 2.453045, 2.14209]);
    let given = conductor("<rgb name=\"eta\" value=\"2, 3, 4\"/><float name=\"k\" value=\"1.5\"/>")
        .expect("given");
    assert_eq!((given.eta, given.k), ([2.0, 3.0, 4.0], [1.5; 3]));
    assert!(conductor("<float name=\"k\" value=\"1.5\"/>").is_err());
    assert!(
        conductor("<float name=\"k\" value=\"1\"/><string name=\"material\" value=\"Cu\"/>")
            .is_err()
    );
    let message = conductor("<string name=\"material\" value=\"Agg\"/>")
        .expect_err("misspelt")
        .to_string();
    assert!(message.contains("did you mean \"Ag\"?"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn transfer_functions_are_inverse(x in 0.0f64..4.0) {
        prop_assert!((srgb_to_linear(linear_to_srgb(x)) - x).abs() < 1e-6 * (1.0 + x));
    }

    #[test]
    fn the_conversion_is_linear(a in 0.0f64..2.0, b in 0.0f64..2.0, cut in 361.0f64..829.0) {
        // A spectrum is the sum of its parts; cut between two samples of the quadrature, no sample counts twice.
        let whole = spectrum_to_srgb(Illuminant::D65, |w| if w < cut { a } else { b });
        let left = spectrum_to_srgb(Illuminant::D65, |w| if w < cut { a } else { 0.0 });
        let right = spectrum_to_srgb(Illuminant::D65, |w| if w < cut { 0.0 } else { b });
        for i in 0..3 {
            prop_assert!((left[i] + right[i] - whole[i]).abs() < 1e-12);
        }
    }

    #[test]
    fn samples_in_between_change_nothing(value in 0.0f64..1.0, at in 401.0f64..699.0) {
        let two = samples_to_srgb(Illuminant::EqualEnergy, &[(400.0, value), (700.0, value)]);
        let three = samples_to_srgb(Illuminant::EqualEnergy, &[(400.0, value), (at, value), (700.0, value)]);
        for i in 0..3 {
            prop_assert!((two[i] - three[i]).abs() < 1e-12);
        }
    }
}
