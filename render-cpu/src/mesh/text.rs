//! Text in mesh files: byte order marks, encodings, and the forms of numbers that other programs write.

use std::borrow::Cow;

/// The text without a byte order mark, in an encoding of single bytes.
pub(super) fn plain(bytes: &[u8]) -> Cow<'_, [u8]> {
    match encoding_rs::Encoding::for_bom(bytes) {
        None => Cow::Borrowed(bytes),
        Some((encoding, mark)) if encoding == encoding_rs::UTF_8 => Cow::Borrowed(&bytes[mark..]),
        Some((encoding, mark)) => {
            let (text, _) = encoding.decode_without_bom_handling(&bytes[mark..]);
            Cow::Owned(text.into_owned().into_bytes())
        }
    }
}

/// A number. What the run-time library of Microsoft's compiler writes for numbers that are none (`1.#QNAN`, `-1.#IND`,
/// `1.#INF`) is understood too.
pub(super) fn number<T: std::str::FromStr + From<f32>>(word: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let (digits, name) = text.split_once('#')?;
    if !matches!(digits, "1." | "-1." | "+1.") {
        return None;
    }
    let infinite = f32::INFINITY.copysign(if digits.starts_with('-') { -1.0 } else { 1.0 });
    match name.get(..3)? {
        "INF" => Some(infinite.into()),
        "QNA" | "SNA" | "IND" => Some(f32::NAN.into()),
        _ => None,
    }
}
