//! Objects and properties that files have in odd places, or under other names.

use crate::Files;

const WALL: &str = r#"<shape type="rectangle"/>"#;

#[test]
fn what_nothing_can_use_is_said() {
    let files = Files::new(&[]);
    let without = files.clean("3.0.0", WALL);
    for object in [
        r#"<film type="hdrfilm"/>"#,
        r#"<sampler type="independent"/>"#,
        r#"<rfilter type="box"/>"#,
        r#"<phase type="hg"/>"#,
        r#"<volume type="constvolume"/>"#,
        r#"<medium type="homogeneous"/>"#,
        r#"<bsdf type="blub"/>"#,
        r#"<texture type="blub"/>"#,
        r#"<shape type="shapegroup"><shape type="sphere"/></shape>"#,
    ] {
        let tables = files.warned("3.0.0", &format!("{WALL}{object}"), "left out");
        assert_eq!(tables, without, "{object}");
        // Definitions need no user.
        let defined = object.replacen(" type", " id=\"a\" type", 1);
        assert_eq!(
            files.clean("3.0.0", &format!("{WALL}{defined}")),
            without,
            "{defined}"
        );
    }
}

#[test]
fn lights_that_are_never_sampled_are_left_out() {
    let files = Files::new(&[]);
    let without = files.clean("3.0.0", WALL);
    for light in ["point", "spot", "directional", "projector"] {
        let weighted = |weight: &str| {
            let light = format!(
                r#"{WALL}<emitter type="{light}"><float name="sampling_weight" value="{weight}"/></emitter>"#
            );
            files.clean("3.0.0", &light)
        };
        assert_eq!(weighted("0"), without, "{light}");
        assert_ne!(weighted("2"), without, "{light}");
    }
    // One that rays can hit is there.
    let lamp = |weight: &str| {
        let lamp =
            format!(r#"<shape type="sphere"><emitter type="area">{weight}</emitter></shape>"#);
        files.clean("3.0.0", &lamp)
    };
    assert_eq!(
        lamp(r#"<float name="sampling_weight" value="0"/>"#),
        lamp("")
    );
}

#[test]
fn older_names_are_understood() {
    let files = Files::new(&[("t.pfm", b"PF\n1 1\n-1\n\0\0\0\x3f\0\0\0\x3f\0\0\0\x3f")]);
    let wall = |bsdf: &str| {
        files.clean(
            "0.6.0",
            &format!(r#"<shape type="rectangle">{bsdf}</shape>"#),
        )
    };
    for (plugin, old, new) in [
        ("roughdiffuse", "diffuseReflectance", "reflectance"),
        ("difftrans", "diffuseTransmittance", "transmittance"),
        ("diffuse", "diffuseReflectance", "reflectance"),
    ] {
        let bsdf = |name: &str| {
            wall(&format!(
                r#"<bsdf type="{plugin}"><rgb name="{name}" value="0.1 0.2 0.3"/></bsdf>"#
            ))
        };
        assert_eq!(bsdf(old), bsdf(new), "{plugin}");
    }
    for (old, new) in [("black", "zero"), ("white", "one")] {
        let bitmap = |mode: &str| {
            wall(&format!(
                r#"<bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="t.pfm"/><string name="wrapMode" value="{mode}"/></texture></bsdf>"#
            ))
        };
        assert_eq!(bitmap(old), bitmap(new), "{old}");
    }
}

#[test]
fn properties_that_change_no_mean_pass() {
    let files = Files::new(&[("t.pfm", b"PF\n1 1\n-1\n\0\0\0\x3f\0\0\0\x3f\0\0\0\x3f")]);
    for content in [
        r#"<integrator type="path"><integer name="samples_per_pass" value="4"/><integer name="block_size" value="16"/></integrator>"#,
        r#"<shape type="sphere"><bsdf type="principled"><float name="diffuse_reflectance_sampling_rate" value="2"/><float name="clearcoat_sampling_rate" value="2"/></bsdf></shape>"#,
        r#"<shape type="sphere"><bsdf type="principledthin"><float name="spec_trans_sampling_rate" value="2"/></bsdf></shape>"#,
        r#"<shape type="rectangle"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="t.pfm"/><string name="format" value="fp16"/><boolean name="accel" value="false"/></texture></bsdf></shape>"#,
    ] {
        files.clean("3.0.0", content);
    }
}

#[test]
fn what_is_not_supported_is_replaced_or_left_out() {
    let files = Files::new(&[]);
    let plain = files.clean("3.0.0", r#"<shape type="sphere"/>"#);
    for light in ["point", "constant", "blub"] {
        let content = format!(
            r#"<shape type="sphere"><emitter type="{light}"><rgb name="radiance" value="2"/></emitter></shape>"#
        );
        assert_eq!(
            files.warned("3.0.0", &content, "only an \"area\" emitter"),
            plain
        );
    }
    let sensor = |plugin: &str| {
        let text = crate::text("3.0.0", r#"<shape type="sphere"/>"#);
        text.replace(
            "<sensor type=\"perspective\"><float name=\"fov\" value=\"28.072486935852958\"/>",
            &format!("<sensor type=\"{plugin}\">"),
        )
    };
    for (plugin, instead) in [
        ("distant", "orthographic"),
        ("telecentric", "orthographic"),
        ("perspective_rdist", "perspective"),
        ("fluencemeter", "perspective"),
    ] {
        let scene = files.load(sensor(plugin).as_bytes(), false).unwrap();
        assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
        let said = scene.warnings[0].to_string();
        assert!(
            said.contains(&format!("\"{instead}\" is used instead")),
            "{said}"
        );
        let known = files.load(sensor(instead).as_bytes(), true).unwrap();
        assert_eq!(scene.tables.fingerprint(), known.tables.fingerprint());
        files
            .load(sensor(plugin).as_bytes(), true)
            .expect_err("strictly an error");
    }
}

#[test]
fn properties_of_other_integrators_are_said() {
    let files = Files::new(&[]);
    let integrator = |plugin: &str, property: &str| {
        format!(r#"<integrator type="{plugin}">{property}</integrator>"#)
    };
    let count = |name: &str| format!(r#"<integer name="{name}" value="3"/>"#);
    for (plugin, name) in [
        ("path", "emitterSamples"),
        ("path", "photon_count"),
        ("bdpt", "chains"),
        ("direct", "ray_length"),
        ("ao", "bsdf_samples"),
        ("sppm", "luminance_samples"),
    ] {
        let content = integrator(plugin, &count(name));
        files.warned(
            "3.0.0",
            &content,
            &format!("\"{plugin}\" does not use this, but "),
        );
        // A parameter may name the one that does.
        let chosen = format!(
            "<default name=\"i\" value=\"{plugin}\"/>{}",
            integrator("$i", &count(name))
        );
        files.clean("3.0.0", &chosen);
    }
    for (plugin, name) in [
        ("direct", "emitterSamples"),
        ("ao", "shading_samples"),
        ("vcm", "photon_count"),
        ("mcppm", "photon_count"),
        ("bpm", "nearest"),
        ("mept", "chains"),
        ("mlt", "chains"),
        ("path", "max_depth"),
    ] {
        files.clean("3.0.0", &integrator(plugin, &count(name)));
    }
}

#[test]
fn a_projector_has_a_focal_length() {
    let files = Files::new(&[]);
    let projector = |property: &str| {
        files.clean(
            "3.0.0",
            &format!(r#"<emitter type="projector">{property}</emitter>"#),
        )
    };
    let normal = projector("");
    assert_eq!(
        projector(r#"<string name="focal_length" value="50mm"/>"#),
        normal
    );
    let fov = 2.0 * (0.5 * 36.0_f64.hypot(24.0) / 50.0).atan().to_degrees();
    let same =
        format!(r#"<float name="fov" value="{fov}"/><string name="fov_axis" value="diagonal"/>"#);
    assert_eq!(projector(&same), normal);
    assert_ne!(
        projector(r#"<string name="focal_length" value="85"/>"#),
        normal
    );
}

#[test]
fn bumps_may_be_turned_inside_out_by_their_textures() {
    let files = Files::new(&[("h.exr", &crate::images::exr([0.5, 0.25, 0.5, 1.0]))]);
    let heights = r#"<texture type="bitmap"><string name="filename" value="h.exr"/></texture>"#;
    let wall = |scale: &str, texture: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="bumpmap">{scale}{texture}<bsdf type="diffuse"/></bsdf></shape>"#
        )
    };
    let factor = |value: &str| format!(r#"<float name="scale" value="{value}"/>"#);
    let scaled = |value: &str, texture: &str| {
        format!(
            r#"<texture type="scale">{}{texture}</texture>"#,
            factor(value)
        )
    };
    for version in ["0.6.0", "3.0.0"] {
        let expected = files.clean(version, &wall(&factor("-6"), heights));
        let twice = scaled("3", &scaled("-2", heights));
        assert_eq!(files.clean(version, &wall("", &twice)), expected);
        let both = wall(&factor("-3"), &scaled("2", heights));
        assert_eq!(files.clean(version, &both), expected);
    }
}

#[test]
fn what_is_replaced_is_said_once() {
    let files = Files::new(&[]);
    let bsdf = |content: &str| format!(r#"<shape type="sphere">{content}</shape>"#);
    for (content, name) in [
        (
            r#"<bsdf type="irawan"><string name="filename" value="x.wv"/><float name="repeatU" value="2"/></bsdf>"#,
            "irawan",
        ),
        (
            r#"<bsdf type="diffuse"><texture name="reflectance" type="curvature"><float name="scale" value="2"/></texture></bsdf>"#,
            "curvature",
        ),
    ] {
        files.warned("0.6.0", &bsdf(content), name);
    }
}

#[test]
fn bounds_are_said_in_numbers_that_can_be_read() {
    let files = Files::new(&[]);
    for (content, words) in [
        (
            r#"<shape type="sphere"><bsdf type="coating"><float name="thickness" value="-1"/><bsdf type="diffuse"/></bsdf></shape>"#,
            ": -1 is below 0",
        ),
        (
            r#"<shape type="sphere"><bsdf type="phong"><float name="exponent" value="-3"/></bsdf></shape>"#,
            "cannot be negative",
        ),
        (
            r#"<emitter type="spot"><float name="cutoffAngle" value="0"/></emitter>"#,
            ": 0 is outside of [0.001, 180]",
        ),
    ] {
        let error = files.error("0.6.0", content);
        assert!(error.contains(words), "{error}");
    }
    for bytes in ["", "  \n", "v 0 0 0\nf 1 1 1\n", "{}"] {
        let error = files.load(bytes.as_bytes(), false).expect_err("no scene");
        assert!(error.contains("no element in it"), "{error}");
    }
}
