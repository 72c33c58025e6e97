//! Colours of vertices and faces that are written as bytes where numbers up to one are meant.

use super::Attribute;

/// What becomes of colours that are whole numbers up to 255, some of them above one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bytes {
    /// They are divided by 255.
    AreScaled,
    /// They are kept: radiance may be like that.
    AreKept,
}

/// Divides the values of a colour that are bytes, or only says that they look so.
pub(super) fn decode(color: &mut Attribute, bytes: Bytes) -> Option<String> {
    let values = &mut color.values;
    let is_byte = |v: &f32| v.fract() == 0.0 && (0.0..=255.0).contains(v);
    if !values.iter().any(|v| *v > 1.0) || !values.iter().all(is_byte) {
        return None;
    }
    let what = match bytes {
        Bytes::AreScaled => {
            values.iter_mut().for_each(|v| *v /= 255.0);
            "are taken for bytes and divided by 255"
        }
        Bytes::AreKept => "look like bytes, but are used as they are",
    };
    Some(format!("the colours \"{}\" {what}", color.name))
}
