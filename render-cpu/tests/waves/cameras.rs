//! Sensors, reconstruction filters and windows of the film.

use crate::files::Files;
use crate::room::{CONSTANT, Room};

fn agrees(files: &Files, plugin: &str, inside: &str, film: &str) {
    let mut room = Room::with_material(r#"<bsdf type="roughplastic"/>"#);
    room.sensor = [plugin.into(), inside.into(), film.into()];
    room.emitters += CONSTANT;
    room.agrees(files);
}

const FIELD: &str = r#"<float name="fov" value="55"/>"#;

#[test]
fn pinholes() {
    let files = Files::new();
    agrees(&files, "perspective", FIELD, "");
    let shifted = r#"<float name="fov" value="40"/><float name="principal_point_offset_x" value="0.1"/>
        <float name="principal_point_offset_y" value="-0.2"/>"#;
    agrees(&files, "perspective", shifted, "");
    let clipped = r#"<float name="near_clip" value="2.5"/><float name="far_clip" value="5"/>"#;
    agrees(&files, "perspective", &format!("{FIELD}{clipped}"), "");
}

#[test]
fn lenses() {
    let files = Files::new();
    for radius in [0.0, 0.01, 0.3] {
        let lens = format!(
            r#"{FIELD}<float name="aperture_radius" value="{radius}"/><float name="focus_distance" value="4"/>"#
        );
        agrees(&files, "thinlens", &lens, "");
    }
}

#[test]
fn parallel_rays() {
    let files = Files::new();
    agrees(&files, "orthographic", "", "");
    let clipped = r#"<float name="near_clip" value="3"/><float name="far_clip" value="5"/>"#;
    agrees(&files, "orthographic", clipped, "");
}

#[test]
fn panoramas() {
    let files = Files::new();
    agrees(&files, "spherical", "", "");
    let window = r#"<integer name="crop_offset_x" value="5"/><integer name="crop_width" value="13"/>
        <rfilter type="lanczos"/>"#;
    agrees(&files, "panoramic", "", window);
}

#[test]
fn filters() {
    let files = Files::new();
    for filter in [
        r#"<rfilter type="box"/>"#,
        r#"<rfilter type="box"><float name="radius" value="1.3"/></rfilter>"#,
        r#"<rfilter type="tent"/>"#,
        r#"<rfilter type="gaussian"><float name="stddev" value="0.8"/></rfilter>"#,
        r#"<rfilter type="mitchell"/>"#,
        r#"<rfilter type="catmullrom"/>"#,
        r#"<rfilter type="lanczos"/>"#,
    ] {
        agrees(&files, "perspective", FIELD, filter);
    }
}

#[test]
fn windows_of_the_film() {
    let files = Files::new();
    for [x, y, width, height] in [[0, 0, 7, 24], [5, 9, 13, 8], [23, 23, 1, 1]] {
        let window = format!(
            r#"<integer name="crop_offset_x" value="{x}"/><integer name="crop_offset_y" value="{y}"/>
            <integer name="crop_width" value="{width}"/><integer name="crop_height" value="{height}"/>"#
        );
        for filter in [r#"<rfilter type="box"/>"#, r#"<rfilter type="lanczos"/>"#] {
            agrees(&files, "perspective", FIELD, &format!("{window}{filter}"));
        }
    }
}
