//! Materials, rules, filters and settings, one at a time, before a lamp that rays meet.

use crate::agreement::{Algorithms, Batches, agree, compare, report, settings_of};
use crate::case::{Case, ball, check, sheet};
use crate::matrix::{BLOCK, DIFFUSE, WARM, lamp, room, sensor};
use crate::scenes::scene;
use halflight_kernel::transport::settings::integrator_kind;

#[test]
fn a_collimated_beam() {
    let beam = |target: &str| {
        format!(
            r#"<emitter type="collimated"><rgb name="power" value="3, 2, 1"/><transform name="to_world">
            <lookat origin="0.6, 1.5, -0.9" target="{target}" up="0, 0, 1"/></transform></emitter>"#
        )
    };
    // Through a pane and off a mirror.
    let pane = sheet!(r#"<bsdf type="thindielectric"/>"#);
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="-125"/>
        <translate x="0.3" y="0.2" z="-0.6"/></transform><bsdf type="conductor"/></shape>"#;
    let mut results = Vec::new();
    for (what, lamp, object) in [
        ("a beam", beam("-0.4, 0.2, -0.6"), BLOCK.to_owned()),
        (
            "a beam through glass",
            beam("0.3, 0.2, -0.6"),
            format!("{pane}{mirror}"),
        ),
    ] {
        let text = format!(
            r#"<integrator type="bdpt"><integer name="max_depth" value="5"/></integrator>{}{lamp}{}"#,
            sensor("perspective"),
            room(DIFFUSE, &object)
        );
        let algorithms = Algorithms::LightAndBidirectional;
        results.extend(agree(what, &mut scene(&text, &[]), algorithms, 16));
    }
    report(results);
}

#[test]
fn materials() {
    let seen = Algorithms::PathAndBidirectional;
    check([
        Case {
            object: ball!(r#"<bsdf type="dielectric"/>"#),
            algorithms: seen,
            samples: 24,
            ..Case::new("glass ball")
        },
        Case {
            object: ball!(
                r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#
            ),
            samples: 24,
            ..Case::new("rough glass ball")
        },
        Case {
            object: sheet!(
                r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/><float name="int_ior" value="1.7"/></bsdf>"#
            ),
            samples: 24,
            ..Case::new("one rough interface")
        },
        Case {
            object: sheet!(r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>"#),
            algorithms: seen,
            samples: 24,
            ..Case::new("one smooth interface")
        },
        Case {
            object: sheet!(r#"<bsdf type="thindielectric"/>"#),
            algorithms: seen,
            samples: 16,
            ..Case::new("thin glass")
        },
        Case {
            object: sheet!(
                r#"<bsdf type="principledthin"><rgb name="base_color" value="0.8, 0.6, 0.4"/><float name="spec_trans" value="0.6"/>
                <float name="roughness" value="0.6"/><float name="diff_trans" value="0.8"/></bsdf>"#
            ),
            samples: 24,
            ..Case::new("a thin sheet")
        },
        Case {
            object: sheet!(
                r#"<bsdf type="hk"><rgb name="sigmaS" value="2, 1, 0.5"/><rgb name="sigmaA" value="0.1, 0.1, 0.3"/>
                <float name="thickness" value="0.5"/><phase type="hg"><float name="g" value="0.4"/></phase></bsdf>"#
            ),
            algorithms: seen,
            samples: 24,
            ..Case::new("a scattering layer")
        },
        Case {
            material: r#"<bsdf type="roughplastic"><float name="alpha" value="0.2"/><rgb name="diffuse_reflectance" value="0.6, 0.4, 0.2"/></bsdf>"#,
            samples: 16,
            ..Case::new("rough plastic")
        },
        Case {
            material: r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.6, 0.4, 0.2"/></bsdf>"#,
            algorithms: seen,
            samples: 24,
            ..Case::new("plastic")
        },
        Case {
            material: r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="diffuse"/>
                <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></bsdf>"#,
            samples: 16,
            ..Case::new("blend")
        },
        Case {
            object: ball!(
                r#"<bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="0.3, 0.6, 0.9"/></emitter>"#
            ),
            ..Case::new("emitter that scatters")
        },
    ]);
}

#[test]
fn shading_normals() {
    let bumps = r#"<bsdf type="bumpmap"><texture type="bitmap"><string name="filename" value="ripples.exr"/>
        <boolean name="raw" value="true"/></texture><float name="scale" value="0.4"/><bsdf type="diffuse">
        <rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></bsdf>"#;
    let normals = r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap">
        <string name="filename" value="ripples.exr"/><boolean name="raw" value="true"/></texture><bsdf type="diffuse">
        <rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></bsdf>"#;
    let rough = r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap">
        <string name="filename" value="ripples.exr"/><boolean name="raw" value="true"/></texture>
        <bsdf type="roughconductor"><float name="alpha" value="0.4"/></bsdf></bsdf>"#;
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/>
        <rotate y="1" angle="60"/><translate x="-1.2" y="0.6" z="-0.4"/></transform><bsdf type="normalmap">
        <texture name="normalmap" type="bitmap"><string name="filename" value="ripples.exr"/>
        <boolean name="raw" value="true"/></texture><bsdf type="conductor"/></bsdf></shape>"#;
    let glass = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.6"/><rotate x="1" angle="90"/>
        <translate x="0.5" y="1.1" z="-0.8"/></transform><bsdf type="bumpmap"><texture type="bitmap">
        <string name="filename" value="ripples.exr"/><boolean name="raw" value="true"/></texture>
        <float name="scale" value="0.3"/><bsdf type="dielectric"/></bsdf></shape>"#;
    let facets = r#"<shape type="obj"><string name="filename" value="sphere.obj"/><transform name="to_world">
        <scale value="0.5"/><translate x="-0.2" y="0.6" z="-0.3"/></transform><ref id="wall"/></shape>"#;
    let mirror_facets = r#"<shape type="obj"><string name="filename" value="sphere.obj"/><transform name="to_world">
        <scale value="0.5"/><translate x="-0.2" y="0.6" z="-0.3"/></transform><bsdf type="conductor"/></shape>"#;
    let strict = r#"<boolean name="strict_normals" value="true"/>"#;
    let seen = Algorithms::PathAndBidirectional;
    // Light walks alone do not take directions in which a map's normal is mirrored towards the viewer but not towards the
    // light: ptracer loses 1 to 3 % on these maps, which are steep.
    check([
        Case {
            material: bumps,
            algorithms: seen,
            ..Case::new("bump map")
        },
        Case {
            material: normals,
            algorithms: seen,
            ..Case::new("normal map")
        },
        Case {
            material: rough,
            samples: 16,
            algorithms: seen,
            ..Case::new("normal map on a rough conductor")
        },
        Case {
            object: mirror,
            algorithms: seen,
            samples: 24,
            ..Case::new("normal map on a mirror")
        },
        Case {
            object: glass,
            algorithms: seen,
            samples: 24,
            ..Case::new("bump map on glass")
        },
        Case {
            object: facets,
            ..Case::new("interpolated normals")
        },
        Case {
            object: mirror_facets,
            algorithms: seen,
            samples: 24,
            ..Case::new("interpolated normals of a mirror")
        },
        Case {
            material: bumps,
            integrator: strict,
            algorithms: seen,
            ..Case::new("bump map, strict normals")
        },
        Case {
            material: normals,
            integrator: strict,
            algorithms: seen,
            ..Case::new("normal map, strict normals")
        },
        Case {
            object: facets,
            integrator: strict,
            ..Case::new("interpolated normals, strict normals")
        },
    ]);
}

#[test]
fn depths() {
    let depths: Vec<String> = (1..=6)
        .map(|depth| format!(r#"<integer name="max_depth" value="{depth}"/>"#))
        .collect();
    let ball = ball!(
        r#"<bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="0.3, 0.6, 0.9"/></emitter>"#
    );
    let names: Vec<String> = (1..=6)
        .map(|depth| format!("at most {depth} edges"))
        .collect();
    check(depths.iter().zip(&names).map(|(depth, name)| Case {
        integrator: depth,
        object: ball,
        ..Case::new(name)
    }));
}

#[test]
fn films() {
    let crop = r#"<integer name="crop_width" value="7"/><integer name="crop_height" value="5"/>
        <integer name="crop_offset_x" value="4"/><integer name="crop_offset_y" value="2"/>"#;
    let filter = |kind: &str| format!(r#"<rfilter type="{kind}"/>"#);
    let kinds = ["box", "tent", "gaussian", "mitchell", "lanczos"];
    let whole = kinds.map(filter);
    let cropped = kinds.map(|kind| format!("{crop}{}", filter(kind)));
    let cases = kinds.iter().zip(&whole).chain(kinds.iter().zip(&cropped));
    check(cases.map(|(kind, film)| Case {
        film,
        samples: 12,
        ..Case::new(kind)
    }));
}

#[test]
fn clipping_planes_and_wide_lenses() {
    // The gauze of a curtain stands before the near clipping plane and is not seen, nor does it hide anything.
    let curtain = concat!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="0.3"/><translate x="0.3" y="1.2" z="2.2"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#,
        r#"<shape type="rectangle"><transform name="to_world"><scale value="0.2"/><translate x="0" y="1" z="1.9"/></transform>
        <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>"#,
    );
    let clipped = r#"<float name="near_clip" value="1.6"/>"#;
    let wide =
        r#"<float name="aperture_radius" value="0.9"/><float name="focus_distance" value="2"/>"#;
    let both = r#"<float name="near_clip" value="1.6"/><float name="aperture_radius" value="0.9"/><float name="focus_distance" value="2"/>"#;
    let mirror = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
        <translate x="-0.4" y="0.8" z="-1.2"/></transform><bsdf type="conductor"/></shape>"#;
    let seen = Algorithms::PathAndBidirectional;
    check([
        Case {
            object: curtain,
            sensor: clipped,
            ..Case::new("near clipping plane")
        },
        Case {
            object: curtain,
            sensor: both,
            ..Case::new("near clipping plane of a wide lens")
        },
        Case {
            sensor: wide,
            ..Case::new("wide lens")
        },
        Case {
            object: mirror,
            sensor: wide,
            algorithms: seen,
            samples: 16,
            ..Case::new("mirror before a wide lens")
        },
    ]);
}

#[test]
fn skies_through_glass() {
    let sky = r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"#;
    let sun = r#"<emitter type="directional"><vector name="direction" value="-0.6, -1, 0.1"/>
        <rgb name="irradiance" value="2, 3, 1"/></emitter>"#;
    let constant = r#"<emitter type="constant"/>"#;
    let glass = ball!(r#"<bsdf type="dielectric"/>"#);
    let rough = ball!(r#"<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>"#);
    let seen = Algorithms::PathAndBidirectional;
    check([
        Case {
            lamp: sky.into(),
            object: glass,
            algorithms: seen,
            samples: 24,
            ..Case::new("sky through glass")
        },
        Case {
            lamp: constant.into(),
            object: glass,
            algorithms: seen,
            samples: 24,
            ..Case::new("constant sky through glass")
        },
        Case {
            lamp: sky.into(),
            object: rough,
            algorithms: seen,
            samples: 24,
            ..Case::new("sky through rough glass")
        },
        Case {
            lamp: sun.into(),
            object: rough,
            samples: 24,
            ..Case::new("sun through rough glass")
        },
    ]);
}

#[test]
fn settings_change_nothing_but_noise() {
    let wide =
        r#"<float name="aperture_radius" value="0.6"/><float name="focus_distance" value="3"/>"#;
    let ball = ball!(r#"<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>"#);
    let lamps = [
        Case::new("").lamp,
        lamp("sphere", r#"<scale value="0.2"/>"#, WARM),
        r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"#.into(),
        r#"<emitter type="point"><point name="position" value="0.6, 1.5, -0.9"/></emitter>"#.into(),
    ];
    let mut results = Vec::new();
    for (i, lamp) in lamps.iter().enumerate() {
        for sensor in ["", wide] {
            let case = Case {
                lamp: lamp.clone(),
                sensor,
                object: ball,
                ..Case::new("settings")
            };
            let mut scene = case.scene();
            let path = settings_of(&scene, integrator_kind::PATH);
            let reference = Batches::render("reference", &mut scene, path, 32);
            for switches in 0..8 {
                let mut settings = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
                settings.bidirectional.sample_direct = switches & 1;
                settings.bidirectional.light_image = switches >> 1 & 1;
                settings.bidirectional.power_heuristic = switches >> 2;
                let what = format!("lamp {i}, sensor {sensor}, switches {switches:b}");
                let image = Batches::render(&what, &mut scene, settings, 8);
                results.push(compare(&what, &image, &reference));
            }
            for connections in [1, 3] {
                let mut settings = settings_of(&scene, integrator_kind::BIDIRECTIONAL);
                settings.bidirectional.connections = connections;
                let what = format!("lamp {i}, sensor {sensor}, {connections} shared");
                let image = Batches::render(&what, &mut scene, settings, 8);
                results.push(compare(&what, &image, &reference));
            }
        }
    }
    report(results);
}
