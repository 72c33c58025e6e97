//! The numbers after the header of a PLY file, in all encodings.

use super::FileLocation;
use super::ply_header::{Element, Encoding, Header, Property, Scalar};

/// The numbers after the header.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    position: usize,
    line: u64,
    encoding: Encoding,
}

impl<'a> Values<'a> {
    /// What follows the header of a file.
    pub(super) fn after(header: &Header, bytes: &'a [u8]) -> Values<'a> {
        Values {
            bytes,
            position: header.end,
            line: header.lines + 1,
            encoding: header.encoding,
        }
    }

    /// The location of the next number.
    pub(super) fn location(&self) -> FileLocation {
        match self.encoding {
            Encoding::Ascii => FileLocation::Line(self.line),
            _ => FileLocation::Offset(self.position as u64),
        }
    }

    /// The number of bytes that nothing has read, but for blanks and zeros that pad a file.
    pub(super) fn rest(&self) -> usize {
        let rest = self.bytes.get(self.position..).unwrap_or_default();
        let is_padding = |b: &u8| b.is_ascii_whitespace() || *b == 0;
        let end = rest.iter().rposition(|b| !is_padding(b));
        let start = rest.iter().position(|b| !is_padding(b));
        match (start, end) {
            (Some(start), Some(end)) => end + 1 - start,
            _ => 0,
        }
    }

    /// Fails unless the rest of the file can hold `count` rows; the one guard before memory is reserved.
    pub(super) fn check_room(&self, element: &Element) -> Result<usize, String> {
        let rest = (self.bytes.len() - self.position) as u64;
        let needed = element
            .count
            .saturating_mul(element.min_bytes(self.encoding));
        if needed > rest {
            return Err(format!(
                "{} rows of \"{}\" are announced, which is more than the file holds",
                element.count, element.name
            ));
        }
        if element.count > 0 && element.properties.is_empty() {
            return Err(format!("\"{}\" has no properties", element.name));
        }
        Ok(element.count as usize)
    }

    /// The next number.
    #[inline]
    pub(super) fn next(&mut self, scalar: Scalar) -> Result<f64, String> {
        if self.encoding == Encoding::Ascii {
            return self.next_ascii(scalar);
        }
        let number = match scalar {
            Scalar::I8 => self.next_bytes().map(|b| f64::from(i8::from_le_bytes(b))),
            Scalar::U8 => self.next_bytes().map(|b| f64::from(u8::from_le_bytes(b))),
            Scalar::I16 => self.next_bytes().map(|b| f64::from(i16::from_le_bytes(b))),
            Scalar::U16 => self.next_bytes().map(|b| f64::from(u16::from_le_bytes(b))),
            Scalar::I32 => self.next_bytes().map(|b| f64::from(i32::from_le_bytes(b))),
            Scalar::U32 => self.next_bytes().map(|b| f64::from(u32::from_le_bytes(b))),
            Scalar::I64 => self.next_bytes().map(|b| i64::from_le_bytes(b) as f64),
            Scalar::U64 => self.next_bytes().map(|b| u64::from_le_bytes(b) as f64),
            Scalar::F32 => self.next_bytes().map(|b| f64::from(f32::from_le_bytes(b))),
            Scalar::F64 => self.next_bytes().map(f64::from_le_bytes),
        };
        number.ok_or_else(|| "the file ends here, too early".into())
    }

    /// The next bytes of a binary file, the lowest first.
    #[inline]
    fn next_bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = *self.bytes[self.position..].first_chunk()?;
        self.position += N;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Some(bytes)
    }

    /// The next row if the file is binary and the row is a list of three 32-bit indices below `count` with a length of
    /// one byte; else nothing is read.
    #[inline]
    pub(super) fn next_triangle(&mut self, count: usize) -> Option<[u32; 3]> {
        if self.encoding == Encoding::Ascii {
            return None;
        }
        let start = self.position;
        let triangle = (self.next_bytes()? == [3])
            .then(|| self.next_bytes::<12>())
            .flatten()
            .map(|bytes| {
                let (words, _) = bytes.as_chunks::<4>();
                let mut triangle = [0, 1, 2].map(|k| u32::from_le_bytes(words[k]));
                if self.encoding == Encoding::BigEndian {
                    // The words were turned round with their bytes.
                    triangle.reverse();
                }
                triangle
            })
            .filter(|triangle| triangle.iter().all(|&i| (i as usize) < count));
        if triangle.is_none() {
            self.position = start;
        }
        triangle
    }

    fn next_ascii(&mut self, scalar: Scalar) -> Result<f64, String> {
        while let Some(&byte) = self.bytes.get(self.position) {
            if !byte.is_ascii_whitespace() {
                break;
            }
            self.line += u64::from(byte == b'\n');
            self.position += 1;
        }
        let rest = &self.bytes[self.position..];
        if rest.is_empty() {
            return Err("the file ends here, too early".into());
        }
        let end = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..end.unwrap_or(rest.len())];
        let text = std::str::from_utf8(word).unwrap_or("");
        let number = match scalar {
            // Rounded once, to the type of the file.
            Scalar::F32 => text.parse::<f32>().map(f64::from),
            _ => text.parse::<f64>(),
        };
        let number = number.ok().or_else(|| super::text::number(word));
        let number = number.ok_or_else(|| {
            let shown = word[..word.len().min(40)].escape_ascii();
            format!("\"{shown}\" is not a number")
        })?;
        self.position += word.len();
        Ok(number)
    }

    /// The length of a list.
    pub(super) fn next_length(&mut self, scalar: Scalar) -> Result<usize, String> {
        let number = self.next(scalar)?;
        // A value takes a byte at least, and what is longer than the file fails before anything is read of it.
        if number < 0.0 || number.fract() != 0.0 || number > (self.bytes.len()) as f64 {
            return Err(format!("{number} is no length of a list in this file"));
        }
        Ok(number as usize)
    }

    /// Reads past a value.
    pub(super) fn skip_property(&mut self, property: &Property) -> Result<(), String> {
        let count = match property.list {
            Some(length) => self.next_length(length)?,
            None => 1,
        };
        for _ in 0..count {
            self.next(property.scalar)?;
        }
        Ok(())
    }
}
