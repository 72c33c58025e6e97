//! Samples of a pass that was cut which pixels have still to get.
//!
//! A pass gives every pixel a number of samples that was decided before it began. When it ends early, some pixels have theirs
//! and others do not. What is pending is kept with the film, in checkpoints too, and given before another pass begins; so the
//! film at the end of a pass does not depend on whether it was cut.

/// Samples that pixels have still to get.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PendingSamples {
    /// Samples per pixel of the whole pass, on average.
    pub per_pixel: u32,
    /// Samples that each pixel has still to get, by rows.
    pub counts: Vec<u32>,
}

impl PendingSamples {
    /// The samples that are missing until all pixels have as many as the one that has most; and how
    /// many of their samples are complete. Pixels below `complete` samples are not of this run and get nothing.
    pub fn to_equal(
        counts: impl Iterator<Item = u32> + Clone,
        complete: u32,
    ) -> (u32, Option<PendingSamples>) {
        // Once over the pixels, which may be many.
        let completed = counts.clone().filter(|&count| count >= complete);
        let range = completed.fold(None, |range, count| {
            let (least, most) = range.unwrap_or((count, count));
            Some((count.min(least), count.max(most)))
        });
        let (least, most) = range.unwrap_or((complete, complete));
        let pending = (most > least).then(|| PendingSamples {
            per_pixel: most - least,
            counts: counts
                .clone()
                .map(|count| if count >= complete { most - count } else { 0 })
                .collect(),
        });
        (least, pending)
    }

    /// The first `limit` samples of the pass alone: what is pending of them.
    pub fn up_to(mut self, limit: u32) -> PendingSamples {
        if limit < self.per_pixel {
            let beyond = self.per_pixel - limit;
            for count in &mut self.counts {
                *count = count.saturating_sub(beyond);
            }
            self.per_pixel = limit;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_owed_what_others_have() {
        let (complete, pending) = PendingSamples::to_equal([7, 5, 6, 0].into_iter(), 5);
        assert_eq!(complete, 5);
        let pending = pending.expect("uneven pixels");
        assert_eq!(
            (pending.per_pixel, &pending.counts[..]),
            (2, &[0, 2, 1, 0][..])
        );
        let one = pending.clone().up_to(1);
        assert_eq!((one.per_pixel, &one.counts[..]), (1, &[0, 1, 0, 0][..]));
        assert_eq!(pending.clone().up_to(9), pending);
        assert_eq!(
            PendingSamples::to_equal([4, 4, 4].into_iter(), 3),
            (4, None)
        );
        // The first pass of all: pixels without a sample are pending theirs.
        let (complete, pending) = PendingSamples::to_equal([1, 0].into_iter(), 0);
        assert_eq!((complete, pending.expect("one").counts), (0, vec![0, 1]));
    }
}
