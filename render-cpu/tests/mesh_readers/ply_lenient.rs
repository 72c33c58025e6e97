//! PLY files that other readers accept: bad faces, elements in another order, colours of every form.

use crate::read_ply;
use halflight::mesh::Mesh;

const POINTS: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "property list uchar int vertex_indices\n";
const SQUARE_POINTS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

fn ascii_of(header: &str, body: &str) -> Mesh {
    let text = format!("ply\nformat ascii 1.0\n{header}end_header\n{body}");
    read_ply(text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn bad_ply_faces_are_left_out() {
    for index in ["9", "-1", "1.5", "nan"] {
        let body = format!("{SQUARE_POINTS}3 0 1 {index}\n3 0 1 2\n");
        let mesh = ascii_of(&format!("{POINTS}element face 2\n{FACES}"), &body);
        assert_eq!(mesh.triangles, [[0, 1, 2]], "{index}");
        assert!(
            mesh.warnings[0].contains("1 faces name vertices"),
            "{:?}",
            mesh.warnings
        );
    }
    let body = SQUARE_POINTS.replace("0 1 0\n", "0 nan 0\n");
    let mesh = ascii_of(
        &format!("{POINTS}element face 2\n{FACES}"),
        &format!("{body}3 0 1 2\n3 0 2 3\n"),
    );
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.warnings.len(), 2, "{:?}", mesh.warnings);
    // In bytes, where triangles are read without a detour.
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\n{POINTS}element face 2\n{FACES}end_header\n"
    )
    .into_bytes();
    for value in [
        0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0,
    ] {
        file.extend(value.to_le_bytes());
    }
    for face in [[0_i32, 1, 7], [0, 1, 2]] {
        file.push(3);
        file.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    assert_eq!(read_ply(&file).unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn ply_headers_as_other_programs_write_them() {
    let plain = ascii_of(
        &format!("{POINTS}element face 1\n{FACES}"),
        &format!("{SQUARE_POINTS}3 0 1 2\n"),
    );
    for faces in [
        "property list uchar int vertex_indexes\n",
        "property list uint8 int64 vertex_indices\n",
        "property list uint64 uint64 vertex_index\n",
    ] {
        let mesh = ascii_of(
            &format!("{POINTS}element face 1\n{faces}"),
            &format!("{SQUARE_POINTS}3 0 1 2\n"),
        );
        assert_eq!(mesh, plain, "{faces}");
    }
    let backwards = ascii_of(
        &format!("element face 1\n{FACES}{POINTS}"),
        &format!("3 0 1 2\n{SQUARE_POINTS}"),
    );
    assert_eq!(backwards, plain);
}

#[test]
fn colours_of_ply_files_have_many_forms() {
    let of = |properties: &str, color: &str| {
        let body = SQUARE_POINTS.replace('\n', &format!(" {color}\n"));
        let mesh = ascii_of(
            &format!("{POINTS}{properties}element face 1\n{FACES}"),
            &format!("{body}3 0 1 2\n"),
        );
        let color = mesh
            .vertex_attributes
            .first()
            .map(|a| a.values[..3].to_vec());
        (color.unwrap_or_default(), mesh.warnings)
    };
    let named = |kind: &str, prefix: &str| {
        ["red", "green", "blue"]
            .map(|c| format!("property {kind} {prefix}{c}\n"))
            .concat()
    };
    let (color, said) = of(&named("uchar", "diffuse_"), "255 51 0");
    assert_eq!((color, said.len()), (vec![1.0, 0.2, 0.0], 0));
    for kind in ["int", "uint", "short"] {
        let (color, said) = of(&named(kind, ""), "255 51 0");
        assert_eq!(color, [1.0, 0.2, 0.0]);
        assert!(
            said.len() == 1 && said[0].contains("taken for bytes"),
            "{said:?}"
        );
    }
    // Radiance may be as large.
    let (color, said) = of(&named("float", ""), "255 51 0");
    assert_eq!(color, [255.0, 51.0, 0.0]);
    assert!(
        said.len() == 1 && said[0].contains("look like bytes"),
        "{said:?}"
    );
    let (color, said) = of(&named("float", ""), "2.5 0.1 0");
    assert_eq!((color, said.len()), (vec![2.5, 0.1, 0.0], 0));
    // What is not used is said, unless it is a measurement.
    let (_, said) = of(
        "property float nx\nproperty float ny\nproperty float quality\n",
        "0 1 2",
    );
    assert!(
        said.len() == 1 && said[0].contains("nx, ny of vertices"),
        "{said:?}"
    );
    let header = format!("{POINTS}element face 1\n{FACES}property list uchar float texcoord\n");
    let mesh = ascii_of(&header, &format!("{SQUARE_POINTS}3 0 1 2 4 0 0 1 1\n"));
    assert!(
        mesh.warnings[0].contains("two numbers"),
        "{:?}",
        mesh.warnings
    );
}
