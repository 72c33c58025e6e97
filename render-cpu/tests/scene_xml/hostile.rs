//! Hostile input costs little and never panics.

use std::path::Path;

use halflight::scene::xml::unused::warn_unused;
use proptest::prelude::*;

use super::*;

#[test]
fn entities_and_depth_are_bounded() {
    let laughs = "<!DOCTYPE s [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]><scene version=\"&b;\"/>";
    assert!(error_of(laughs).contains("malformed XML"));
    let deep = format!(
        "<scene version=\"3.0.0\">{}{}</scene>",
        "<bsdf type=\"t\">".repeat(100_000),
        "</bsdf>".repeat(100_000)
    );
    let message = error_of(&deep);
    assert!(
        message.ends_with("elements are nested more than 64 deep"),
        "{message}"
    );
    // Text doubles with each parameter.
    let mut doubling =
        String::from("<scene version=\"3.0.0\"><default name=\"p0\" value=\"0123456789\"/>");
    for i in 1..60 {
        doubling += &format!("<default name=\"p{i}\" value=\"$p{}$p{}\"/>", i - 1, i - 1);
    }
    let message = error_of(&(doubling + "</scene>"));
    assert!(
        message.ends_with("the value is too long once its parameters are put in"),
        "{message}"
    );
}

const SEED: &str = r##"<scene version="0.6.0"><default name="spp" value="64"/><path value="."/>
<bsdf type="twosided" id="m"><bsdf type="diffuse"><srgb name="reflectance" value="#12aBcd"/></bsdf></bsdf>
<shape type="obj"><transform name="toWorld"><rotate z="1" angle="225"/><scale value="2"/>
<lookAt origin="1,2,3" target="4 5 6" up="0 0 1"/><matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform>
<ref id="m" name="bsdf"/><spectrum name="s" value="400:0.1, 500:0.2"/><point name="p" x="1" y="2" z="$spp"/></shape>
<texture type="bitmap"><float name="uscale" value="3"/></texture><alias id="m" as="n"/><ref id="n"/></scene>"##;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn mutated_scenes_never_panic(
        edits in prop::collection::vec((0..SEED.len(), any::<u8>(), 0..4u8), 1..12),
        strict in any::<bool>(),
    ) {
        let mut bytes = SEED.as_bytes().to_vec();
        for (at, byte, what) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match what {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 => { bytes.remove(at); }
                // Repeat a stretch, so that names and ids collide.
                _ => {
                    let end = (at + usize::from(byte)).min(bytes.len());
                    let stretch = bytes[at..end].to_vec();
                    bytes.splice(at..at, stretch);
                }
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        if let Ok(scene) = parse_scene_from_str(&text, Path::new("scene.xml"), &[], strict) {
            let _ = warn_unused(&scene.root);
            prop_assert!(!strict || scene.warnings().is_empty());
        }
    }

    #[test]
    fn numbers_survive(x in any::<f32>().prop_filter("finite", |x| x.is_finite())) {
        let object = bsdf(&format!("<float name=\"p\" value=\"{x:e}\"/>"));
        prop_assert_eq!(object.get_float("p", 0.0).expect("a float") as f32, x);
    }
}
