//! Tensor files: named arrays of numbers, the container of the RGL database of measured materials.
//!
//! Little endian: the text `tensor_file` and a zero byte, two bytes of the version (1, 0), a `u32` with the number of fields; of each
//! field the length of its name as `u16`, the name, the number of its dimensions as `u16`, a byte for the type of its numbers (1 for
//! `u8`, 10 for `f32`; others are read as nothing), the offset of its data in the file as `u64`, and its dimensions as `u64`.
//!
//! Nothing is reserved before the length of the file is known to suffice.

/// Type of bytes.
const U8: u8 = 1;
/// Type of floats.
const F32: u8 = 10;

/// Bytes of a number by type; zero for types that there are none of.
const SIZES: [usize; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// The most fields and dimensions of a file that means something.
const MOST: usize = 64;

/// Why bytes are no tensor file, or a field is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TensorError {
    /// Another kind of file.
    #[error("this is no tensor file of version 1.0")]
    NoTensorFile,
    /// It ends before what it says.
    #[error("the file ends within {0}")]
    Short(String),
    /// Numbers that make no sense.
    #[error("{0}")]
    Field(String),
}

/// A named array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field<'a> {
    /// Its name.
    pub name: String,
    /// Numbers along each dimension, the last one fastest.
    pub shape: Vec<usize>,
    kind: u8,
    bytes: &'a [u8],
}

impl Field<'_> {
    /// Its floats, all of which are finite.
    ///
    /// # Errors
    /// When it holds other numbers.
    pub fn floats(&self) -> Result<Vec<f32>, TensorError> {
        if self.kind != F32 {
            return Err(self.wrong("should hold single-precision floats"));
        }
        let values = self.bytes.as_chunks::<4>().0.iter();
        let values: Vec<f32> = values.map(|b| f32::from_le_bytes(*b)).collect();
        if values.iter().all(|v| v.is_finite()) {
            Ok(values)
        } else {
            Err(self.wrong("has a value that is not finite"))
        }
    }

    /// Its bytes.
    ///
    /// # Errors
    /// When it holds other numbers.
    pub fn bytes(&self) -> Result<&[u8], TensorError> {
        if self.kind == U8 {
            Ok(self.bytes)
        } else {
            Err(self.wrong("should hold bytes"))
        }
    }

    /// An error about the field.
    pub fn wrong(&self, what: &str) -> TensorError {
        TensorError::Field(format!("the field \"{}\" {what}", self.name))
    }
}

/// Reads the front of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], TensorError> {
        let taken = self
            .at
            .checked_add(count)
            .and_then(|end| self.bytes.get(self.at..end))
            .ok_or_else(|| TensorError::Short(what.into()))?;
        self.at += count;
        Ok(taken)
    }

    /// An unsigned number of `count` bytes.
    fn number(&mut self, count: usize, what: &str) -> Result<usize, TensorError> {
        let bytes = self.take(count, what)?;
        let value = bytes
            .iter()
            .rev()
            .fold(0_u64, |n, b| n << 8 | u64::from(*b));
        usize::try_from(value).map_err(|_| TensorError::Short(what.into()))
    }
}

/// The fields of a file.
///
/// # Errors
/// What is wrong with it.
pub fn read(bytes: &[u8]) -> Result<Vec<Field<'_>>, TensorError> {
    let mut cursor = Cursor { bytes, at: 0 };
    let head = cursor
        .take(14, "its head")
        .map_err(|_| TensorError::NoTensorFile)?;
    if head != b"tensor_file\0\x01\0" {
        return Err(TensorError::NoTensorFile);
    }
    let count = cursor.number(4, "its head")?;
    if count > MOST {
        return Err(TensorError::Field(format!("{count} fields are too many")));
    }
    (0..count).map(|_| field(&mut cursor)).collect()
}

fn field<'a>(cursor: &mut Cursor<'a>) -> Result<Field<'a>, TensorError> {
    let length = cursor.number(2, "a name")?;
    let name = String::from_utf8_lossy(cursor.take(length, "a name")?).into_owned();
    let what = format!("the field \"{name}\"");
    let dimensions = cursor.number(2, &what)?;
    let kind = cursor.number(1, &what)? as u8;
    let at = cursor.number(8, &what)?;
    if dimensions > MOST {
        return Err(TensorError::Field(format!(
            "{what} has {dimensions} dimensions"
        )));
    }
    let shape = (0..dimensions)
        .map(|_| cursor.number(8, &what))
        .collect::<Result<Vec<_>, _>>()?;
    let size = SIZES.get(usize::from(kind)).copied().unwrap_or(0);
    let length = shape
        .iter()
        .try_fold(size, |n: usize, s| n.checked_mul(*s))
        .ok_or_else(|| TensorError::Short(what.clone()))?;
    let data = at
        .checked_add(length)
        .and_then(|end| cursor.bytes.get(at..end))
        .ok_or(TensorError::Short(what))?;
    Ok(Field {
        name,
        shape,
        kind,
        bytes: data,
    })
}

/// The file of floats and bytes by their names, for tests and examples.
pub fn file_of(floats: &[(&str, &[usize], &[f32])], bytes: &[(&str, &[u8])]) -> Vec<u8> {
    let mut head = b"tensor_file\0\x01\0".to_vec();
    head.extend(((floats.len() + bytes.len()) as u32).to_le_bytes());
    let names = floats.iter().map(|f| (f.0, f.1.len()));
    let names = names.chain(bytes.iter().map(|b| (b.0, 1)));
    let mut at = head.len() + names.map(|(n, d)| n.len() + 13 + 8 * d).sum::<usize>();
    let mut data: Vec<u8> = Vec::new();
    let mut add = |name: &str, shape: &[usize], kind: u8, values: &[u8]| {
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape.len() as u16).to_le_bytes());
        head.push(kind);
        head.extend((at as u64).to_le_bytes());
        head.extend(shape.iter().flat_map(|s| (*s as u64).to_le_bytes()));
        data.extend(values);
        at += values.len();
    };
    for (name, shape, values) in floats {
        let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        add(name, shape, F32, &values);
    }
    for (name, values) in bytes {
        add(name, &[values.len()], U8, values);
    }
    head.extend(data);
    head
}
