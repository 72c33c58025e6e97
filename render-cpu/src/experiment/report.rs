//! What an experiment returns.

use crate::plot::Plot;

/// What an experiment found.
#[derive(Clone, Debug)]
pub struct Report {
    /// Tables and what they show.
    pub text: String,
    /// Diagrams.
    pub plots: Vec<Plot>,
    /// Numbers by name, for tests.
    pub figures: Vec<(String, f64)>,
}

impl Report {
    /// A figure by its name.
    pub fn figure(&self, name: &str) -> Option<f64> {
        let found = self.figures.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| *value)
    }
}
