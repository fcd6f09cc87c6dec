//! Letters as outlines, from a subset of DejaVu Sans that lies in the binary (`font/`).

use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Made by `font/subset.sh`; its licence is beside it.
static FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

static FACE: LazyLock<Face<'static>> =
    LazyLock::new(|| Face::parse(FONT, 0).expect("the embedded font is a font, which a test proves"));

/// The height of a capital, in ems. The font states none, so an H is measured.
pub(super) fn cap_height() -> f64 {
    let capital = FACE.glyph_index('H').and_then(|id| FACE.glyph_bounding_box(id));
    capital.map_or(0.0, |around| f64::from(around.y_max)) / units_per_em()
}

/// The width of a line of text, in ems.
pub(super) fn width(text: &str) -> f64 {
    place(text).last().map_or(0.0, |glyph| glyph.left + advance(glyph.id)) / units_per_em()
}

/// The outline of a line of text, `size` pixels an em: it begins at the origin, on the baseline,
/// y down. `None` if nothing shows.
pub(super) fn outline(text: &str, size: f64) -> Option<Path> {
    let scale = size / units_per_em();
    let mut pen = Pen { path: PathBuilder::new(), left: 0.0, scale: scale as f32 };
    for glyph in place(text) {
        pen.left = (glyph.left * scale) as f32;
        FACE.outline_glyph(glyph.id, &mut pen);
    }
    pen.path.finish()
}

/// Does the font have this character?
#[cfg(test)]
pub(super) fn has(character: char) -> bool {
    FACE.glyph_index(character).is_some()
}

struct Placed {
    id: GlyphId,
    /// Where its origin lies, in font units.
    left: f64,
}

/// Letters one after the other, kerned. A character that the font lacks shows as its box.
fn place(text: &str) -> Vec<Placed> {
    let mut placed: Vec<Placed> = Vec::new();
    for character in text.chars() {
        let id = FACE.glyph_index(character).unwrap_or_default();
        let left = placed.last().map_or(0.0, |before| before.left + advance(before.id) + kerning(before.id, id));
        placed.push(Placed { id, left });
    }
    placed
}

fn advance(id: GlyphId) -> f64 {
    FACE.glyph_hor_advance(id).map_or(0.0, f64::from)
}

fn kerning(left: GlyphId, right: GlyphId) -> f64 {
    let tables = FACE.tables().kern.into_iter().flat_map(|kern| kern.subtables);
    let mut pairs = tables.filter(|table| table.horizontal && !table.has_cross_stream);
    pairs.find_map(|table| table.glyphs_kerning(left, right)).map_or(0.0, f64::from)
}

fn units_per_em() -> f64 {
    f64::from(FACE.units_per_em())
}

/// Writes glyph outlines (font units, y up) into a path (pixels, y down).
struct Pen {
    path: PathBuilder,
    left: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.left + self.scale * x, -self.scale * y)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_that_labels_use_is_in_the_font() {
        let labels = " !\"#$%&'()*+,-./0123456789:;<=>?@ABCZ[]^_`abcz{|}~°±²³µ·¹×ΓΔΘΛΣΦΨΩαβγδεθκλμνπρστφχψω–—′⁰⁴⁵⁶⁷⁸⁹⁺⁻₀₁₂₃←↑→↓∂∇∈−√∞≈≠≤≥…";
        for character in labels.chars() {
            assert!(has(character), "{character:?}");
        }
    }

    #[test]
    fn text_grows_by_its_letters_and_digits_are_equally_wide() {
        assert!(width("Loop") > width("Loo"));
        assert_eq!(width(""), 0.0);
        for digit in ["1", "4", "7"] {
            assert_eq!(width(digit), width("0"));
        }
    }

    #[test]
    fn pairs_are_kerned() {
        assert!(width("AV") < width("A") + width("V"));
    }

    #[test]
    fn blanks_have_width_but_no_outline() {
        assert!(width(" ") > 0.0 && outline(" ", 20.0).is_none() && outline("", 20.0).is_none());
    }
}
