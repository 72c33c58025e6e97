//! Numbers and lists of numbers as scene files write them.
//!
//! Numbers are finite and in the range of f32, which is what the kernel computes in; lists are separated by commas,
//! white space or both. Errors are sentences without a location, which the caller adds.

/// A number.
pub fn float(text: &str) -> Result<f64, String> {
    let trimmed = text.trim();
    match trimmed.parse::<f64>() {
        Ok(value) if value.is_finite() && value.abs() <= f64::from(f32::MAX) => Ok(value),
        Ok(_) => Err(format!(
            "the number \"{}\" is not finite in 32 bits",
            shortened(trimmed)
        )),
        Err(_) => Err(format!(
            "expected a number, found \"{}\"",
            shortened(trimmed)
        )),
    }
}

/// An integer.
pub fn integer(text: &str) -> Result<i64, String> {
    let trimmed = text.trim();
    trimmed
        .parse()
        .map_err(|_| format!("expected an integer, found \"{}\"", shortened(trimmed)))
}

/// `true` or `false`, in any case.
pub fn boolean(text: &str) -> Result<bool, String> {
    let trimmed = text.trim();
    if trimmed.eq_ignore_ascii_case("true") {
        Ok(true)
    } else if trimmed.eq_ignore_ascii_case("false") {
        Ok(false)
    } else {
        Err(format!(
            "expected true or false, found \"{}\"",
            shortened(trimmed)
        ))
    }
}

/// The items of a list.
pub fn items(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace())
        .filter(|item| !item.is_empty())
}

/// A list of numbers.
pub fn floats(text: &str) -> Result<Vec<f64>, String> {
    items(text).map(float).collect()
}

/// Three numbers, or one that is repeated.
pub fn triplet(text: &str) -> Result<[f64; 3], String> {
    match *floats(text)? {
        [x] => Ok([x; 3]),
        [x, y, z] => Ok([x, y, z]),
        ref other => Err(format!(
            "expected one or three numbers, found {}",
            other.len()
        )),
    }
}

/// Exactly three numbers.
pub fn vector(text: &str) -> Result<[f64; 3], String> {
    match *floats(text)? {
        [x, y, z] => Ok([x, y, z]),
        ref other => Err(format!("expected three numbers, found {}", other.len())),
    }
}

/// The start of a text, for messages.
pub fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    match text.char_indices().nth(LONGEST) {
        Some((at, _)) => format!("{}...", &text[..at]),
        None => text.into(),
    }
}
