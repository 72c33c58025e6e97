//! The path expressions by which an image is divided into layers.

use crate::expression::PathParts;
use halflight_kernel::path::PathExpressions;

/// What is divided.
#[derive(Clone, Copy)]
pub(super) struct Division<'a> {
    /// The expressions.
    pub expressions: PathExpressions<'a>,
    /// The first that is a layer.
    pub first: usize,
    /// Number of layers.
    pub count: usize,
}

impl<'a> Division<'a> {
    /// By a scene's parts; none if it has none.
    pub fn new(parts: &'a PathParts) -> Option<Division<'a>> {
        Some(Division {
            expressions: parts.view()?,
            first: parts.first_layer(),
            count: parts.request().layers.len(),
        })
    }
}
