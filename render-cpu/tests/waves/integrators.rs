//! Lengths of paths, chance that ends them, emitters that hide, strict normals.

use crate::files::Files;
use crate::room::{CONSTANT, LAMP, POINT, Room, path};

/// Things on which paths go on for long, and a mask in front.
fn room(parameters: &str) -> Room {
    Room {
        integrator: path(parameters),
        walls: r#"<bsdf type="diffuse"><float name="reflectance" value="0.9"/></bsdf>"#.into(),
        emitters: format!("{LAMP}{POINT}{CONSTANT}"),
        shapes: r#"<shape type="rectangle"><transform name="to_world"><scale x="0.5" y="0.5" z="1"/>
            <translate x="0.5" y="0.5" z="1.5"/></transform>
            <bsdf type="mask"><float name="opacity" value="0.4"/><bsdf type="roughconductor"/></bsdf></shape>"#
            .into(),
        ..Room::with_material(r#"<bsdf type="dielectric"/>"#)
    }
}

#[test]
fn lengths_of_paths() {
    let files = Files::new();
    for (depth, least) in [
        (-1, 0.4),
        (0, 0.0),
        (1, 0.02),
        (2, 0.4),
        (3, 0.4),
        (12, 0.4),
    ] {
        let parameters = format!(r#"<integer name="max_depth" value="{depth}"/>"#);
        let room = Room {
            least,
            ..room(&parameters)
        };
        room.agrees(&files);
    }
}

#[test]
fn chance_that_ends_paths() {
    let files = Files::new();
    for depth in [0, 1, 2, 100] {
        let parameters = format!(
            r#"<integer name="max_depth" value="24"/><integer name="rr_depth" value="{depth}"/>"#
        );
        room(&parameters).agrees(&files);
    }
}

#[test]
fn hidden_emitters_and_strict_normals() {
    let files = Files::new();
    for hides in [false, true] {
        for is_strict in [false, true] {
            let parameters = format!(
                r#"<integer name="max_depth" value="6"/><boolean name="hide_emitters" value="{hides}"/>
                <boolean name="strict_normals" value="{is_strict}"/>"#
            );
            room(&parameters).agrees(&files);
            let plain = Room {
                integrator: path(&parameters),
                ..Room::with_material(r#"<bsdf type="roughplastic"/>"#)
            };
            plain.agrees(&files);
        }
    }
}
