//! PLY files in all encodings, to be read by the tests.

#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Encoding {
    Ascii,
    Little,
    Big,
}

pub(crate) const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::Little, Encoding::Big];

/// Writes one file.
pub(crate) struct PlyWriter {
    pub bytes: Vec<u8>,
    encoding: Encoding,
}

impl PlyWriter {
    pub fn new(encoding: Encoding, header: &str) -> PlyWriter {
        let format = match encoding {
            Encoding::Ascii => "ascii",
            Encoding::Little => "binary_little_endian",
            Encoding::Big => "binary_big_endian",
        };
        let text = format!("ply\nformat {format} 1.0\ncomment by hand\n{header}end_header\n");
        PlyWriter {
            bytes: text.into_bytes(),
            encoding,
        }
    }

    pub fn put(&mut self, scalar: &str, value: f64) {
        if self.encoding == Encoding::Ascii {
            self.bytes.extend(format!("{value} ").bytes());
            return;
        }
        let mut word = match scalar {
            "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
            "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
            "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
            "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
            "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
            "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
            "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if self.encoding == Encoding::Big {
            word.reverse();
        }
        self.bytes.extend(word);
    }

    pub fn end_row(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.bytes.push(b'\n');
        }
    }
}

/// A file from scalar columns and faces, each followed by face columns.
pub(crate) fn ply_file(
    encoding: Encoding,
    vertex: &[(&str, &str)],
    rows: &[Vec<f64>],
    list: (&str, &str),
    face: &[(&str, &str)],
    faces: &[(&[u32], Vec<f64>)],
) -> Vec<u8> {
    let mut header = format!("element vertex {}\n", rows.len());
    for (scalar, name) in vertex {
        header += &format!("property {scalar} {name}\n");
    }
    header += &format!("element face {}\n", faces.len());
    header += &format!("property list {} {} vertex_indices\n", list.0, list.1);
    for (scalar, name) in face {
        header += &format!("property {scalar} {name}\n");
    }
    let mut file = PlyWriter::new(encoding, &header);
    for row in rows {
        for ((scalar, _), value) in vertex.iter().zip(row) {
            file.put(scalar, *value);
        }
        file.end_row();
    }
    for (corners, values) in faces {
        file.put(list.0, corners.len() as f64);
        for corner in *corners {
            file.put(list.1, f64::from(*corner));
        }
        for ((scalar, _), value) in face.iter().zip(values) {
            file.put(scalar, *value);
        }
        file.end_row();
    }
    file.bytes
}

pub(crate) const XYZ: [(&str, &str); 3] = [("float", "x"), ("float", "y"), ("float", "z")];

pub(crate) fn square_rows(extra: &[f64]) -> Vec<Vec<f64>> {
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .iter()
        .map(|[x, y]| [&[*x, *y, 0.0], extra].concat())
        .collect()
}
