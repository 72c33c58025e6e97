//! Edits of light transport: that algorithms agree on them, what they do to energy, and mistakes in their files.

mod agreement;
mod energy;
mod identity;
mod mistakes;
mod scenes;
