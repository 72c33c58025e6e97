//! An 8-bit RGB image to draw diagrams on and to put pictures into.
//!
//! Text is set in DejaVu Sans, which is embedded in the program: a drawing does not depend on the fonts of the system.

use plotters::coord::Shift;
use plotters::prelude::{BitMapBackend, DrawingArea, IntoDrawingArea, IntoFont};
use plotters::style::{FontStyle, TextStyle, register_font};
use std::sync::OnceLock;

/// The name under which diagrams ask for the font.
pub const FONT: &str = "sans-serif";

/// Why something could not be drawn.
pub type DrawError = Box<dyn std::error::Error + Send + Sync>;

/// What diagrams draw on.
pub type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// An image, white at first.
pub struct Canvas {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Canvas {
    /// A white image.
    pub fn new(width: u32, height: u32) -> Canvas {
        Canvas {
            width,
            height,
            rgb: vec![255; 3 * width as usize * height as usize],
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The bytes, three per pixel.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Lets `draw` draw on the whole image.
    ///
    /// # Errors
    /// What `draw` returns; or the font cannot be used.
    pub fn draw(
        &mut self,
        draw: impl FnOnce(&Area<'_>) -> Result<(), DrawError>,
    ) -> Result<(), DrawError> {
        static REGISTERED: OnceLock<bool> = OnceLock::new();
        let registered = REGISTERED.get_or_init(|| {
            register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).is_ok()
        });
        if !registered {
            return Err("the font of the diagrams cannot be used".into());
        }
        let area = BitMapBackend::with_buffer(&mut self.rgb, (self.width, self.height))
            .into_drawing_area();
        draw(&area)?;
        area.present()?;
        Ok(())
    }

    /// Copies a picture of `width` by `height` pixels to (x, y); what lies outside is cut off.
    pub fn paste(&mut self, picture: &[u8], [width, height]: [u32; 2], x: u32, y: u32) {
        let rows = height.min(self.height.saturating_sub(y));
        let columns = width.min(self.width.saturating_sub(x)) as usize;
        for row in 0..rows {
            let from = 3 * (row * width) as usize;
            let to = 3 * ((y + row) as usize * self.width as usize + x as usize);
            self.rgb[to..to + 3 * columns].copy_from_slice(&picture[from..from + 3 * columns]);
        }
    }
}

/// A text style of a size.
pub fn text_style(size: u32) -> TextStyle<'static> {
    (FONT, size).into_font().into()
}
