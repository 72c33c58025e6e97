//! Samples that a pass which was cut still owes to the pixels.
//!
//! A pass gives every pixel a number of samples that was decided before it began. When it ends early, some pixels have theirs
//! and others do not. What is owed is kept with the film, in checkpoints too, and given before another pass begins; so the
//! film at the end of a pass does not depend on whether it was cut.

/// What pixels are owed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Owed {
    /// Samples per pixel of the whole pass, on average.
    pub per_pixel: u32,
    /// Samples that each pixel is owed, by rows.
    pub counts: Vec<u32>,
}

impl Owed {
    /// What pixels that got different numbers of samples are owed until all have as many as the one that has most; and how
    /// many of their samples are complete. Pixels below `complete` samples are not of this run and get nothing.
    pub fn to_equal(
        counts: impl Iterator<Item = u32> + Clone,
        complete: u32,
    ) -> (u32, Option<Owed>) {
        // Once over the pixels, which may be many.
        let own = counts.clone().filter(|&count| count >= complete);
        let range = own.fold(None, |range, count| {
            let (least, most) = range.unwrap_or((count, count));
            Some((count.min(least), count.max(most)))
        });
        let (least, most) = range.unwrap_or((complete, complete));
        let owed = (most > least).then(|| Owed {
            per_pixel: most - least,
            counts: counts
                .clone()
                .map(|count| if count >= complete { most - count } else { 0 })
                .collect(),
        });
        (least, owed)
    }

    /// The first `limit` samples of the pass alone: what is owed of them.
    pub fn up_to(mut self, limit: u32) -> Owed {
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
        let (complete, owed) = Owed::to_equal([7, 5, 6, 0].into_iter(), 5);
        assert_eq!(complete, 5);
        let owed = owed.expect("uneven pixels");
        assert_eq!((owed.per_pixel, &owed.counts[..]), (2, &[0, 2, 1, 0][..]));
        let one = owed.clone().up_to(1);
        assert_eq!((one.per_pixel, &one.counts[..]), (1, &[0, 1, 0, 0][..]));
        assert_eq!(owed.clone().up_to(9), owed);
        assert_eq!(Owed::to_equal([4, 4, 4].into_iter(), 3), (4, None));
        // The first pass of all: pixels without a sample are owed theirs.
        let (complete, owed) = Owed::to_equal([1, 0].into_iter(), 0);
        assert_eq!((complete, owed.expect("one").counts), (0, vec![0, 1]));
    }
}
