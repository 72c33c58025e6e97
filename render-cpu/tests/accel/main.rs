//! Trees over primitives, and the walks through them.

mod geometry;
mod hits;
mod lanes;
mod trees;
