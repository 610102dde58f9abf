//! Pictures: the light form of a drawing at two pixels a unit.

use std::sync::{Arc, LazyLock};

use resvg::{tiny_skia, usvg};

use super::Svg;

/// Pixels of a picture at most; larger drawings are refused.
const MOST_PIXELS: f64 = 2.0e8;

static FONTS: LazyLock<Arc<usvg::fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(include_bytes!("../../assets/Inter-Regular.otf").to_vec());
    fonts.load_font_data(include_bytes!("../../assets/Inter-SemiBold.otf").to_vec());
    fonts.set_sans_serif_family("Inter");
    Arc::new(fonts)
});

impl Svg {
    /// The drawing in its light form as a PNG at two pixels a unit.
    ///
    /// # Errors
    /// A sentence where the drawing has no size, is larger than 200 million pixels, or is not valid.
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        let (width, height) = ((2.0 * self.width).ceil(), (2.0 * self.height).ceil());
        if !(width >= 1.0 && height >= 1.0 && width * height <= MOST_PIXELS) {
            return Err(format!(
                "a picture of {width} × {height} pixels cannot be made"
            ));
        }
        let options = usvg::Options {
            font_family: "Inter".to_owned(),
            fontdb: Arc::clone(&FONTS),
            ..usvg::Options::default()
        };
        let tree = usvg::Tree::from_str(&self.light(), &options)
            .map_err(|error| format!("the drawing cannot be made a picture: {error}"))?;
        let mut pixels = tiny_skia::Pixmap::new(width as u32, height as u32)
            .ok_or_else(|| "there is no memory for the picture".to_owned())?;
        resvg::render(
            &tree,
            tiny_skia::Transform::from_scale(2.0, 2.0),
            &mut pixels.as_mut(),
        );
        pixels
            .encode_png()
            .map_err(|error| format!("the picture cannot be written: {error}"))
    }
}
