//! Regularisation on a scene: the comparisons of the paper's figures, measured.
//!
//! Every algorithm runs without regularisation and with several kinds of it (Jendersie and Grosch 2019, figures 3, 5, 7 and 11;
//! Kaplanyan 2017, figures 6.1 and 6.4), all for the same processor time or the same number of samples
//! ([`super::convergence`]). The numbers are the paper's: sigma, the noise of the image estimated from its own samples, and the
//! root mean square of relative residuals, which holds the bias and the light that is missing as well.

use super::convergence::Outcome;
use crate::scene::build::regularization::{parse_mollify, parse_regularize, refusal};
use halflight_kernel::transport::IntegratorSettings;
use std::fmt::Write;

/// A kind of regularisation, as the command line writes it.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// What stands in the table.
    pub name: &'static str,
    /// The value of `--regularize`, or of `--mollify` where it begins with r0; nothing for none.
    pub options: &'static str,
}

/// What is compared: none, a sweep of tau, a tau that stays, heuristics, weights that know nothing of regularisation,
/// virtual merges, and path space.
pub const VARIANTS: [Variant; 14] = [
    variant("none", ""),
    variant("tau 10", "tau=10"),
    variant("tau 30", "tau=30"),
    variant("tau 100", "tau=100"),
    variant("tau 1000", "tau=1000"),
    variant("tau 30, constant", "tau=30,constant"),
    variant("tau 30, quality", "tau=30,quality"),
    variant("tau 30, both heuristics", "tau=30,quality,diffusion"),
    variant("tau 30, plain weights", "tau=30,weights=plain"),
    variant(
        "tau 30, constant, plain weights",
        "tau=30,constant,weights=plain",
    ),
    variant("tau 10, both heuristics", "tau=10,quality,diffusion"),
    variant("tau 1000, both heuristics", "tau=1000,quality,diffusion"),
    variant("tau 30, virtual merge", "tau=30,virtual"),
    variant("r0 1 %", "r0=1%"),
];

const fn variant(name: &'static str, options: &'static str) -> Variant {
    Variant { name, options }
}

impl Variant {
    /// The settings of an algorithm with this kind; nothing where it does not have it.
    ///
    /// # Errors
    /// If the options are not understood.
    pub fn of(&self, settings: &IntegratorSettings) -> Result<Option<IntegratorSettings>, String> {
        let mut candidate = *settings;
        candidate.regularization = if self.options.is_empty() {
            halflight_kernel::transport::settings::RegularizationSettings::NONE
        } else if self.options.starts_with("r0") {
            parse_mollify(self.options)?
        } else {
            parse_regularize(self.options)?
        };
        Ok(refusal(&candidate).is_none().then_some(candidate))
    }
}

/// The last images' numbers as a table.
pub fn table(outcomes: &[Outcome]) -> String {
    let width = outcomes.iter().map(|o| o.name.len()).max().unwrap_or(0);
    let mut text = format!(
        "{:<width$}  samples   seconds      mean     sigma    RMS RE   rel MSE  trimmed\n",
        ""
    );
    for outcome in outcomes {
        let Some(last) = outcome.curve.last() else {
            continue;
        };
        let pixels = &outcome.image.pixels;
        let sum: f64 = pixels.iter().flatten().sum();
        let mean = sum / (3 * pixels.len().max(1)) as f64;
        let e = &last.errors;
        let _ = writeln!(
            text,
            "{:<width$} {:>8} {:>9.1} {:>9.4} {:>9.4} {:>9.4} {:>9.4} {:>8.4}",
            outcome.name,
            last.samples,
            last.seconds,
            mean,
            e.sigma,
            e.residual_rms,
            e.relative_mse,
            e.trimmed
        );
    }
    text
}
