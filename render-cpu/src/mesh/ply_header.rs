//! The header of a PLY file: its encoding, elements and their properties.

use super::{FileLocation, MeshError};
use std::path::Path;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Scalar> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "int64" => Scalar::I64,
            "uint64" => Scalar::U64,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Whether it is a number of whole ones.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }
}

/// A property of an element: a number, or a list with its length before it.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Type of the length, for lists.
    pub(super) list: Option<Scalar>,
}

impl Property {
    /// Fewest bytes that a value takes.
    fn min_bytes(&self, encoding: Encoding) -> usize {
        match encoding {
            Encoding::Ascii => 1,
            _ => self.list.unwrap_or(self.scalar).bytes(),
        }
    }
}

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes that a row takes.
    pub(super) fn min_bytes(&self, encoding: Encoding) -> u64 {
        let bytes = self.properties.iter().map(|p| p.min_bytes(encoding) as u64);
        bytes.sum()
    }
}

/// What a PLY file holds.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Files of textures, which programs name in comments.
    pub(super) texture_files: Vec<String>,
    /// Offset of the first byte after the header.
    pub(super) end: usize,
    /// Lines of the header.
    pub(super) lines: u64,
}

impl Header {
    pub(super) fn read(bytes: &[u8], file: &Path) -> Result<Header, MeshError> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut texture_files = Vec::new();
        let mut end = 0;
        let mut number = 0;
        // Programs of old Macintoshes end lines with a carriage return alone.
        let first = bytes.iter().find(|&&b| b == b'\n' || b == b'\r');
        let has_returns_only = first == Some(&b'\r') && bytes.get(4) != Some(&b'\n');
        let line_end = if has_returns_only { b'\r' } else { b'\n' };
        loop {
            let rest = &bytes[end..];
            let fail = |what: &str| {
                Err(MeshError::malformed(
                    file,
                    FileLocation::Line(number + 1),
                    what,
                ))
            };
            let Some(length) = rest.iter().position(|&b| b == line_end) else {
                return fail(if number == 0 {
                    "not a PLY file"
                } else {
                    "the header does not end"
                });
            };
            let line = rest[..length].trim_ascii();
            if number == 0 && line != b"ply" {
                return fail("not a PLY file");
            }
            end += length + 1;
            let text = String::from_utf8_lossy(line);
            texture_files.extend(texture_file(&text));
            let mut words = text.split_ascii_whitespace();
            let keyword = words.next().unwrap_or("");
            let words: Vec<&str> = match keyword {
                "comment" | "obj_info" => Vec::new(),
                _ => words.collect(),
            };
            match (keyword, &words[..]) {
                ("ply", []) if number == 0 => {}
                ("comment" | "obj_info" | "", _) => {}
                ("format", [name, version]) => {
                    if *version != "1.0" {
                        return fail("the version is not 1.0");
                    }
                    encoding = Some(match *name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return fail("unknown format"),
                    });
                }
                ("element", [name, count]) => {
                    let Ok(count) = count.parse() else {
                        return fail("the element's count is not a number");
                    };
                    elements.push(Element {
                        name: (*name).to_owned(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ("property", ["list", length, scalar, name]) => {
                    let (Some(length), Some(scalar)) =
                        (Scalar::parse(length), Scalar::parse(scalar))
                    else {
                        return fail("unknown type of a property");
                    };
                    let Some(element) = elements.last_mut() else {
                        return fail("a property before any element");
                    };
                    element.properties.push(Property {
                        name: (*name).to_owned(),
                        scalar,
                        list: Some(length),
                    });
                }
                ("property", [scalar, name]) => {
                    let Some(scalar) = Scalar::parse(scalar) else {
                        return fail("unknown type of a property");
                    };
                    let Some(element) = elements.last_mut() else {
                        return fail("a property before any element");
                    };
                    element.properties.push(Property {
                        name: (*name).to_owned(),
                        scalar,
                        list: None,
                    });
                }
                ("end_header", []) => {
                    let Some(encoding) = encoding else {
                        return fail("the header names no format");
                    };
                    return Ok(Header {
                        encoding,
                        elements,
                        texture_files,
                        end,
                        lines: number + 1,
                    });
                }
                _ => return fail("this line of the header cannot be understood"),
            }
            number += 1;
        }
    }
}

/// The file that a comment such as `comment TextureFile wood.png` names.
fn texture_file(line: &str) -> Option<String> {
    let comment = line.strip_prefix("comment")?.trim_start();
    let (word, name) = comment.split_once([' ', '\t'])?;
    (word.eq_ignore_ascii_case("TextureFile") && !name.trim().is_empty())
        .then(|| name.trim().to_owned())
}
