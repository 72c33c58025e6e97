//! What is wrong with an expression, and where.

use std::fmt;

/// A mistake in a path expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    /// The expression.
    pub text: String,
    /// Number of characters before the mistake.
    pub position: usize,
    /// What is wrong.
    pub message: String,
}

impl ExpressionError {
    /// A mistake behind `position` characters of `text`.
    pub(super) fn new(text: &str, position: usize, message: impl Into<String>) -> ExpressionError {
        ExpressionError {
            text: text.to_owned(),
            position,
            message: message.into(),
        }
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (text, column, message) = (&self.text, self.position + 1, &self.message);
        write!(
            f,
            "path expression \"{text}\", character {column}: {message}"
        )
    }
}

impl std::error::Error for ExpressionError {}
