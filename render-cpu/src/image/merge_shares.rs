//! Layers of regularisation while images are merged.
//!
//! `regularization.share` is the share s of a pixel's luminance l, `regularization.scale` the mean a of tau or of the radius in
//! logarithms, weighted by regularised light. Neither is a mean over samples; `l s` and `l s ln a` are. Images are merged in that form.

use super::ExrImage;
use crate::film::{luminance, share_and_scale};
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
    let regularized = |i: usize| share[i] * luminance([r[i], g[i], b[i]].map(f64::from)) as f32;
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
    let colours = ["R", "G", "B"].map(&mut channel);
    let ([Some(r), Some(g), Some(b)], Some(share)) = (colours, channel(SHARE)) else {
        return;
    };
    let mut none = Vec::new();
    let scale = channel(SCALE).unwrap_or(&mut none);
    scale.resize(share.len(), 0.0);
    for (i, (share, scale)) in share.iter_mut().zip(scale).enumerate() {
        let whole = luminance([r[i], g[i], b[i]]);
        [*share, *scale] = share_and_scale(whole, *share, *scale);
    }
}
