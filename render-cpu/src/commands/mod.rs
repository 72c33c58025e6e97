//! The subcommands of `halflight`, one per file.

pub mod compare;
pub mod merge;
