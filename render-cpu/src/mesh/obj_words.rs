//! Words of the lines of OBJ files: numbers and indices.

use super::text::number;

/// The index of a corner: a whole number, which some programs write with a fraction of zero.
pub(super) fn index(word: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(word).ok()?;
    // What is too large for a number of an element is none either way.
    let whole = |x: &f64| x.fract() == 0.0;
    let fraction = || text.parse().ok().filter(whole).map(|x| x as i64);
    text.parse().ok().or_else(fraction)
}

/// The first `N` numbers of a line, and how many there are.
pub(super) fn numbers<'a, const N: usize>(
    words: impl Iterator<Item = &'a [u8]>,
) -> Result<([f32; N], usize), String> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for (slot, word) in numbers.iter_mut().zip(words) {
        *slot = number(word).ok_or_else(|| format!("\"{}\" is not a number", show(word)))?;
        count += 1;
    }
    Ok((numbers, count))
}

/// A word for a message: printable and not too long.
pub(super) fn show(word: &[u8]) -> String {
    word[..word.len().min(40)].escape_ascii().to_string()
}
