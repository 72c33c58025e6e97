//! Limits on the resources that a scene file can consume.
//!
//! Each limit is far above what real scenes need; exceeding one is an error with its location.

/// Nesting of elements, and length of a chain of references.
pub const MAX_DEPTH: usize = 64;
/// Nesting of included files, as in Mitsuba.
pub const MAX_INCLUDE_DEPTH: usize = 15;
/// Files read, counting repeated ones.
pub const MAX_FILES: usize = 4096;
/// Bytes read, over all files and counting repeated ones.
pub const MAX_BYTES: u64 = 2 << 30;
/// Elements over all files.
pub const MAX_ELEMENTS: usize = 10_000_000;
/// Length of an attribute after its parameters are put in, when it has any.
pub const MAX_SUBSTITUTED: usize = 1 << 16;
/// Bytes of attributes after substitution, over all files.
pub const MAX_SUBSTITUTED_TOTAL: usize = 1 << 28;
