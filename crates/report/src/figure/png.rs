//! Drawings as pixels.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Why a drawing could not become pixels.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PngError {
    /// The drawing is no SVG.
    #[error("a drawing cannot be read")]
    Svg(#[from] resvg::usvg::Error),
    /// The drawing has no size.
    #[error("a drawing without any size")]
    Size,
    /// The pixels cannot be written.
    #[error("a drawing cannot be encoded: {reason}")]
    Encode {
        /// What the encoder says.
        reason: String,
    },
}

/// Pixels for each unit of a drawing.
const SCALE: f32 = 2.0;

/// The pixels of the drawing `svg` as a PNG file.
pub(crate) fn png(svg: &str) -> Result<Vec<u8>, PngError> {
    let mut options = Options { font_family: "DejaVu Sans".into(), ..Options::default() };
    options.fontdb_mut().load_font_data(dejavu::sans::regular().to_vec());
    options.fontdb_mut().set_sans_serif_family("DejaVu Sans");
    let tree = Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size().scale_by(SCALE);
    let size = size.ok_or(PngError::Size)?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or(PngError::Size)?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| PngError::Encode { reason: e.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_becomes_pixels_without_any_font_of_the_machine() {
        let svg = |text: &str| {
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"60\" height=\"30\"><style>text {{ font: 13px system-ui, 'DejaVu Sans', \
                 sans-serif; }}</style><text x=\"5\" y=\"20\">{text}</text></svg>"
            )
        };
        let (some, none) = (png(&svg("θ −ω")).expect("it is a drawing"), png(&svg("")).expect("it is a drawing"));
        assert_eq!(some[..4], *b"\x89PNG");
        assert!(some.len() > none.len() + 200, "{} against {} bytes", some.len(), none.len());
        assert!(png("no drawing").is_err());
    }
}
