//! Trees over primitives, and the walks through them.

#[path = "../../../kernel/tests/common/empty_tables.rs"]
mod empty_tables;
mod geometry;
mod hits;
mod lanes;
mod pairs;
mod trees;
