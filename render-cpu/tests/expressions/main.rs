//! Path expressions: what they match, and what they make of an image.

mod commands;
mod images;
mod matcher;
mod matching;
mod mistakes;
mod scenes;
