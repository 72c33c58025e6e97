//! Thick lines with smooth edges and arrow heads, over the bytes of an image.

use glam::Vec2;

/// An RGB image that lines are drawn on.
pub(super) struct Sheet<'a> {
    /// Width and height.
    pub size: [u32; 2],
    /// Three bytes per pixel.
    pub rgb: &'a mut [u8],
}

impl Sheet<'_> {
    /// Blends a colour over the pixels by their coverage, for pixels in the box around `points` and `margin` more.
    fn blend(&mut self, points: &[Vec2], margin: f32, color: [u8; 3], cover: impl Fn(Vec2) -> f32) {
        let [width, height] = self.size.map(|s| s as f32);
        let low = points.iter().fold(Vec2::MAX, |a, b| a.min(*b)) - margin;
        let high = points.iter().fold(Vec2::MIN, |a, b| a.max(*b)) + margin;
        if !(high.x > 0.0 && high.y > 0.0 && low.x < width && low.y < height) {
            return;
        }
        let range =
            |low: f32, high: f32, most: f32| (low.max(0.0) as usize, high.min(most - 1.0) as usize);
        let (x0, x1) = range(low.x, high.x, width);
        let (y0, y1) = range(low.y, high.y, height);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let part = cover(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)).clamp(0.0, 1.0);
                let at = 3 * (y * self.size[0] as usize + x);
                for c in 0..3 {
                    let old = f32::from(self.rgb[at + c]);
                    self.rgb[at + c] = (old + part * (f32::from(color[c]) - old)).round() as u8;
                }
            }
        }
    }

    /// A line with round ends.
    pub fn line(&mut self, a: Vec2, b: Vec2, thickness: f32, color: [u8; 3], opacity: f32) {
        let along = b - a;
        let square = along.length_squared().max(1e-12);
        let cover = |p: Vec2| {
            let t = ((p - a).dot(along) / square).clamp(0.0, 1.0);
            opacity * (0.5 * thickness + 0.5 - p.distance(a + along * t))
        };
        // Beyond the edge by half a pixel, over which the coverage falls.
        self.blend(&[a, b], 0.5 * thickness + 1.0, color, |p| {
            cover(p).min(opacity)
        });
    }

    /// An arrow head with its tip at `tip`, which points along `direction`.
    pub fn head(&mut self, tip: Vec2, direction: Vec2, size: f32, color: [u8; 3], opacity: f32) {
        let forward = direction.normalize_or_zero();
        if forward == Vec2::ZERO {
            return;
        }
        let side = forward.perp();
        let back = tip - forward * size;
        let corners = [
            tip,
            back + side * (0.45 * size),
            back - side * (0.45 * size),
        ];
        let slope = 0.45;
        let cover = |p: Vec2| {
            // Distances to the three edges, inside positive.
            let along = (p - back).dot(forward);
            let across = (p - tip).dot(side).abs();
            let from_tip = (tip - p).dot(forward);
            let edge = (slope * from_tip - across) / (1.0 + slope * slope).sqrt();
            (along + 0.5).min(edge + 0.5).clamp(0.0, 1.0) * opacity
        };
        self.blend(&corners, 1.0, color, cover);
    }
}
