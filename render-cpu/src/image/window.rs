//! Rectangles of pixels within one image.

use super::MAX_SAMPLES;

/// A rectangle of pixels: its first one in the coordinates of the whole image, and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First pixel.
    pub origin: [i32; 2],
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// One after the last pixel.
    fn end(&self) -> [i64; 2] {
        let [x, y] = self.origin.map(i64::from);
        [x + i64::from(self.width), y + i64::from(self.height)]
    }

    /// Whether the two have a pixel in common.
    pub fn meets(&self, other: &Window) -> bool {
        let (a, b) = (self.end(), other.end());
        (0..2).all(|axis| {
            i64::from(self.origin[axis]) < b[axis] && i64::from(other.origin[axis]) < a[axis]
        })
    }

    /// The smallest rectangle that holds both; none if it has more pixels than images may have.
    pub fn union(&self, other: &Window) -> Option<Window> {
        let origin: [i32; 2] =
            std::array::from_fn(|axis| self.origin[axis].min(other.origin[axis]));
        let (a, b) = (self.end(), other.end());
        let [width, height] =
            std::array::from_fn(|axis| a[axis].max(b[axis]) - i64::from(origin[axis]));
        let is_small = width.checked_mul(height)? as u64 <= MAX_SAMPLES;
        is_small.then_some(Window {
            origin,
            width: u32::try_from(width).ok()?,
            height: u32::try_from(height).ok()?,
        })
    }

    /// Where the pixels, by rows, are among those of a rectangle that holds this one.
    pub fn indices_in(self, larger: &Window) -> impl Iterator<Item = usize> {
        let left = self.origin[0].abs_diff(larger.origin[0]) as usize;
        let top = self.origin[1].abs_diff(larger.origin[1]) as usize;
        let across = larger.width as usize;
        (0..self.height as usize)
            .flat_map(move |y| (0..self.width as usize).map(move |x| (top + y) * across + left + x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn window(x: i32, y: i32, width: u32, height: u32) -> Window {
        Window {
            origin: [x, y],
            width,
            height,
        }
    }

    #[test]
    fn rectangles_meet_and_unite() {
        let a = window(2, 3, 4, 2);
        assert!(a.meets(&window(5, 4, 9, 9)));
        assert!(!a.meets(&window(6, 3, 1, 1)) && !a.meets(&window(2, 5, 1, 1)));
        let both = a.union(&window(-1, 4, 2, 3));
        assert_eq!(both, Some(window(-1, 3, 7, 4)));
        assert_eq!(
            window(i32::MIN, 0, 1, 1).union(&window(i32::MAX, 9, 1, 1)),
            None
        );
        let places: Vec<usize> = window(1, 4, 2, 2).indices_in(&window(0, 3, 5, 3)).collect();
        assert_eq!(places, [6, 7, 11, 12]);
    }
}
