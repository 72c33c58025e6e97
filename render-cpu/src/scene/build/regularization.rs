//! Regularisation as text, in scene files and on the command line: `tau=30`, `r0=1%,kernel=constant`.

use crate::integrators::INTEGRATORS;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::regularize::bandwidth::{TAU_MAX, TAU_MIN, is_consistent};
use halflight_kernel::regularize::mollifier;
use halflight_kernel::regularize::settings::{RegularizationSettings, flag};
use halflight_kernel::transport::markov::primary_space::technique;
use halflight_kernel::transport::settings::ChainSettings;
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};

/// Why edits and regularisation do not go together.
pub const EDITED: &str = "edits turn paths as they are, not those that regularisation has spread";

/// Dimensions of what is mollified: the direction at one vertex.
const DIMENSIONS: u32 = 2;

/// Whether the algorithm's connections can be regularised.
fn can_be_regularized(settings: &IntegratorSettings) -> bool {
    let merges = settings.kind == integrator_kind::VERTEX_MERGING;
    let connects = settings.photon.connections != 0;
    settings.kind == integrator_kind::PATH
        || settings.kind == integrator_kind::BIDIRECTIONAL
        || merges && connects
        || is_of_chains(settings)
}

/// Whether chains make paths by connections that can be regularised.
fn is_of_chains(settings: &IntegratorSettings) -> bool {
    let is_bidirectional = settings.chains.technique == technique::BIDIRECTIONAL;
    settings.kind == integrator_kind::VEACH_MLT
        || settings.kind == integrator_kind::PRIMARY_SAMPLE_MLT && is_bidirectional
}

/// Why an algorithm cannot be regularised as its settings ask, in one sentence.
pub fn refusal(settings: &IntegratorSettings) -> Option<String> {
    let regularization = &settings.regularization;
    let direct = settings.chains.direct_samples;
    let is_of_samples = settings.kind == integrator_kind::PRIMARY_SAMPLE_MLT;
    let of_path = flag::ALL_LIGHTS | flag::VIRTUAL_MERGE;
    if !regularization.is_some() {
        None
    } else if !can_be_regularized(settings) {
        Some(format!(
            "regularize and mollify are for {}",
            regularized_names()
        ))
    } else if regularization.flags & of_path != 0 && settings.kind != integrator_kind::PATH {
        Some("virtual and lights=all are for path".to_string())
    } else if regularization.is_adaptive() && is_of_chains(settings) {
        Some("quality and diffusion are for path, bdpt and vcm".to_string())
    } else if regularization.tau < TAU_MAX && settings.kind == integrator_kind::VEACH_MLT {
        Some(
            "chains of whole paths take mollify; regularize is for pssmlt among chains".to_string(),
        )
    } else if regularization.one_minus_gamma > 0.0
        && regularization.one_minus_gamma != RegularizationSettings::DEFAULT_RATE
        && !is_of_chains(settings)
    {
        Some("gamma is for Markov chains".to_string())
    } else if is_of_samples && direct != 0 && direct != ChainSettings::SOME {
        Some("regularised chains of primary samples find all light by themselves, without direct samples".to_string())
    } else {
        None
    }
}

/// The names of those algorithms.
fn regularized_names() -> String {
    let of = |kind: u32| {
        let mut settings = IntegratorSettings::PATH;
        settings.kind = kind;
        can_be_regularized(&settings)
    };
    let names: Vec<_> = INTEGRATORS
        .iter()
        .filter(|i| of(i.kind) && i.name != "vm" && i.name != "mmlt")
        .map(|i| i.name)
        .collect();
    names.join(", ")
}

/// What the plugin says: `regularize` and `mollify`.
///
/// # Errors
/// If it cannot be understood.
pub(super) fn read(
    object: &Object,
    regularization: &mut RegularizationSettings,
) -> Result<(), SceneError> {
    for (name, parse) in [
        ("regularize", parse_regularize as Parse),
        ("mollify", parse_mollify),
    ] {
        let text = object.get_string(name, "")?.to_owned();
        if !text.is_empty() {
            if regularization.is_some() {
                return Err(object.error("takes one of regularize and mollify, not both"));
            }
            *regularization =
                parse(&text).map_err(|error| object.error(format!("{name}: {error}")))?;
        }
    }
    Ok(())
}

type Parse = fn(&str) -> Result<RegularizationSettings, String>;

/// Regularisation of microfacet models: tau, and what follows it.
///
/// # Errors
/// What was expected.
pub fn parse_regularize(text: &str) -> Result<RegularizationSettings, String> {
    has_once(text, "tau")?;
    let mut regularization = RegularizationSettings::NONE;
    for word in text.split(',').map(str::trim) {
        match word.split_once('=') {
            Some(("tau", "inf")) => regularization.tau = TAU_MAX,
            Some(("tau", value)) => {
                regularization.tau = number(value, |v| v >= f64::from(TAU_MIN))
                    .ok_or("tau is a value per steradian, 0.16 or more, or inf")?
                    .min(f64::from(TAU_MAX)) as f32;
            }
            Some(("lambda", value)) => regularization.exponent = exponent(value)?,
            Some(("fade", value)) => {
                regularization.fade = number(value, |v| (0.0..=1.0).contains(&v))
                    .ok_or("fade lies between 0 and 1")?
                    as f32;
                regularization.flags |= flag::QUALITY;
            }
            None if word == "quality" => regularization.flags |= flag::QUALITY,
            Some(("weights", "plain")) => regularization.flags |= flag::PLAIN_WEIGHTS,
            None if word == "virtual" => regularization.flags |= flag::VIRTUAL_MERGE,
            None if word == "diffusion" => regularization.flags |= flag::DIFFUSION,
            _ => shared(
                word,
                &mut regularization,
                "tau=30, lambda=0.167, quality, fade=0.5, diffusion, virtual, weights=plain, constant and lights=all",
            )?,
        }
    }
    Ok(regularization)
}

/// Regularisation of path space: the radius r0, and what follows it.
///
/// # Errors
/// What was expected.
pub fn parse_mollify(text: &str) -> Result<RegularizationSettings, String> {
    has_once(text, "r0")?;
    let mut regularization = RegularizationSettings::NONE;
    let mut rate = None;
    for word in text.split(',').map(str::trim) {
        match word.split_once('=') {
            Some(("r0", value)) => {
                let (value, unit) = match value.strip_suffix('%') {
                    Some(share) => (share, 0.01),
                    None => (value, 1.0),
                };
                let r0 = number(value, |v| (0.0..1e30).contains(&v))
                    .ok_or("r0 is a length, or as in 1% a share of the scene's radius")?;
                regularization.radius = (r0 * unit) as f32;
                if unit < 1.0 {
                    regularization.flags |= flag::RELATIVE_RADIUS;
                }
            }
            Some(("lambda", value)) => regularization.exponent = exponent(value)?,
            Some(("gamma", value)) => {
                let gamma = number(value, |v| v > 0.0 && v <= 1.0)
                    .ok_or("gamma lies between 0 and 1, as 0.9999")?;
                rate = Some((1.0 - gamma) as f32);
            }
            Some(("quantile", value)) => {
                regularization.quantile = number(value, |v| v > 0.0 && v <= 1.0)
                    .ok_or("quantile is a share above 0, at most 1, which is for none")?
                    as f32;
            }
            Some(("kernel", name)) => {
                regularization.kernel = match name {
                    "constant" => mollifier::CONSTANT,
                    "parabolic" => mollifier::PARABOLIC,
                    "quartic" => mollifier::QUARTIC,
                    "perlin" => mollifier::PERLIN,
                    _ => return Err("kernels are constant, parabolic, quartic and perlin".into()),
                };
            }
            _ => shared(
                word,
                &mut regularization,
                "r0=1%, lambda=0.167, gamma=0.9999, kernel=perlin, quantile=0.9, constant and lights=all",
            )?,
        }
    }
    if regularization.flags & flag::CONSTANT != 0 {
        regularization.one_minus_gamma = 0.0;
    }
    regularization.one_minus_gamma = rate.unwrap_or(regularization.one_minus_gamma);
    Ok(regularization)
}

fn shared(
    word: &str,
    regularization: &mut RegularizationSettings,
    known: &str,
) -> Result<(), String> {
    regularization.flags |= match word {
        "constant" => flag::CONSTANT,
        "lights=all" => flag::ALL_LIGHTS,
        "lights=one" => 0,
        _ => {
            return Err(format!(
                "expected {known}, with commas between, not \"{word}\""
            ));
        }
    };
    Ok(())
}

/// That the first of all words is there, and none of them twice.
fn has_once(text: &str, first: &str) -> Result<(), String> {
    let mut names: Vec<&str> = text
        .split(',')
        .map(|w| w.split('=').next().unwrap_or(w).trim())
        .collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("{} is there twice", pair[0])),
        None if !names.contains(&first) => {
            let example = if first == "tau" { "tau=30" } else { "r0=1%" };
            Err(format!("{first} is missing, as in {example}"))
        }
        None => Ok(()),
    }
}

fn exponent(text: &str) -> Result<f32, &'static str> {
    let exponent = number(text, |v| is_consistent(v as f32, DIMENSIONS));
    Ok(exponent.ok_or("lambda lies above 0 and below 1/2")? as f32)
}

fn number(text: &str, holds: impl Fn(f64) -> bool) -> Option<f64> {
    text.trim().parse().ok().filter(|v: &f64| holds(*v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_mean_what_they_say() {
        let regularization = parse_regularize("tau=30").unwrap();
        assert!(
            regularization.tau == 30.0 && regularization.flags == 0 && regularization.is_some()
        );
        let regularization = parse_regularize("tau=50, constant,lights=all").unwrap();
        assert_eq!(regularization.flags, flag::CONSTANT | flag::ALL_LIGHTS);
        assert!(!parse_regularize("tau=inf").unwrap().is_some());
        assert_eq!(
            parse_regularize("tau=30,lambda=0.25").unwrap().exponent,
            0.25
        );
        assert!(parse_regularize("tau=30,lambda=0.5").is_err());
        let regularization = parse_mollify("r0=1%").unwrap();
        assert!(regularization.radius == 0.01 && regularization.flags == flag::RELATIVE_RADIUS);
        let regularization = parse_mollify("r0=0.25,kernel=constant,lambda=0.25").unwrap();
        assert!(
            regularization.radius == 0.25
                && regularization.exponent == 0.25
                && regularization.flags == 0
        );
        assert_eq!(regularization.kernel, mollifier::CONSTANT);
        assert!(!parse_mollify("r0=0").unwrap().is_some());
        let rate = |text| parse_mollify(text).unwrap().one_minus_gamma;
        assert_eq!(rate("r0=1%"), RegularizationSettings::DEFAULT_RATE);
        assert_eq!(rate("r0=1%,constant"), 0.0);
        assert_eq!(rate("gamma=0.75,r0=1%,constant"), 0.25);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, part) in [
            ("tau=0.1", "0.16"),
            ("tau", "\"tau\""),
            ("tau=30,r0=1%", "\"r0=1%\""),
            ("quality", "tau is missing"),
            ("tau=30,tau=40", "twice"),
        ] {
            let error = parse_regularize(text).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        for (text, part) in [
            ("r0=-1", "length"),
            ("lambda=0.2", "r0 is missing"),
            ("r0=1%,lambda=0.5", "1/2"),
            ("r0=1%,gamma=1.5", "0.9999"),
            ("r0=1%,kernel=x", "perlin"),
            ("r0=1%,r0=2%", "twice"),
        ] {
            let error = parse_mollify(text).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
