//! Layers of regularisation while images are merged.
//!
//! `regularization.share` is the share s of a pixel's luminance l, `regularization.scale` the mean a of tau or of the radius in
//! logarithms, weighted by regularised light. Neither is a mean over samples; `l s` and `l s ln a` are. Images are merged in that form.

use super::ExrImage;
use glam::Vec3;
use halflight_kernel::math::luminance;
use std::borrow::Cow;

const SHARE: &str = "regularization.share";
const SCALE: &str = "regularization.scale";

/// The values of a channel of an image as means over samples.
pub(super) fn to_means<'a>(
    image: &'a ExrImage,
    channel: &str,
    values: &'a [f32],
) -> Cow<'a, [f32]> {
    let parts = ["R", "G", "B", SHARE].map(|name| image.channel(name));
    let [Some(r), Some(g), Some(b), Some(share)] = parts else {
        return Cow::Borrowed(values);
    };
    let regularized = |i: usize| share[i] * luminance(Vec3::new(r[i], g[i], b[i]));
    match channel {
        SHARE => Cow::Owned((0..values.len()).map(regularized).collect()),
        SCALE => {
            let of = |(i, scale): (usize, &f32)| {
                if *scale > 0.0 {
                    regularized(i) * scale.ln()
                } else {
                    0.0
                }
            };
            Cow::Owned(values.iter().enumerate().map(of).collect())
        }
        _ => Cow::Borrowed(values),
    }
}

/// Turns merged means back into what the layers show; `channel` finds a channel's values.
pub(super) fn from_means<'a>(mut channel: impl FnMut(&str) -> Option<&'a mut Vec<f64>>) {
    let (Some(r), Some(g), Some(b)) = (channel("R"), channel("G"), channel("B")) else {
        return;
    };
    let whole = |i: usize| f64::from(luminance(Vec3::new(r[i] as f32, g[i] as f32, b[i] as f32)));
    let Some(share) = channel(SHARE) else {
        return;
    };
    if let Some(scale) = channel(SCALE) {
        for (scale, sum) in scale.iter_mut().zip(share.iter()) {
            *scale = if *sum > 0.0 {
                (*scale / sum).exp()
            } else {
                0.0
            };
        }
    }
    for (i, share) in share.iter_mut().enumerate() {
        let whole = whole(i);
        // A filter has negative weights.
        *share = if whole > 0.0 {
            (*share / whole).clamp(0.0, 1.0)
        } else {
            0.0
        };
    }
}
