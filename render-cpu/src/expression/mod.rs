//! Path expressions: from text to the tables that the kernel reads
//! ([`halflight_kernel::path::expression`]).
//!
//! | file | content |
//! |---|---|
//! | [`parser`], `vertex_parser`, [`syntax`] | both notations, and the tree that they are read into |
//! | [`names`] | what a scene has names for |
//! | `alphabet` | which vertices an expression tells apart |
//! | `read` | expressions over the letters of a scene |
//! | `positions` | the automaton of an expression's atoms |
//! | `automaton` | deterministic automata from both ends |
//! | `unmatched` | where an expression that no path can match goes wrong |
//! | [`compile`](mod@compile) | all of them together |
//! | [`selections`] | parts of paths, for edits |
//! | [`error`] | what is wrong, and where |
//! | [`parts`] | what is asked for of an image, and its layers |
//!
//! Automata libraries (`regex-automata`, `fst`) read bytes, find one match among many and read from one end; here letters come
//! from a scene, all expressions that match count, and the states of both ends must be known to each other.

mod alphabet;
mod automaton;
pub mod compile;
pub mod error;
pub mod names;
pub mod parser;
pub mod parts;
mod positions;
mod read;
pub mod selections;
pub mod syntax;
mod unmatched;
mod vertex_parser;

pub use compile::{CompiledExpressions, compile};
pub use error::ExpressionError;
pub use names::SceneNames;
pub use parser::parse;
pub use parts::{PartsError, PartsRequest, PathParts};
