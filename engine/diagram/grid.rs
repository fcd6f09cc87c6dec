//! Several pictures as one figure, in rows and columns, each over its caption.

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, TextStyle, text_width};
use super::colour::{Colour, palette};
use super::error::DiagramError;

/// A picture of a figure, and what stands below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The picture.
    pub picture: Canvas,
    /// Words below it, broken into lines where they are too many; may be empty.
    pub caption: String,
}

impl Cell {
    /// A picture over its caption.
    pub fn new(picture: Canvas, caption: impl Into<String>) -> Self {
        Self { picture, caption: caption.into() }
    }
}

/// Do captions begin with a letter in parentheses?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Letters {
    /// Just the captions.
    Without,
    /// `(a)`, `(b)` and so on.
    With,
}

/// How a figure is laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Pictures in a row.
    pub columns: usize,
    /// Pixels between pictures and around the figure.
    pub gap: u32,
    /// Pixels an em of captions.
    pub text: f64,
    /// Do captions begin with letters?
    pub letters: Letters,
    /// Above the figure; may be empty.
    pub title: String,
    /// The colour between pictures.
    pub background: Colour,
}

impl Grid {
    /// So many pictures in a row, without letters or a title, captions of `text` pixels an em.
    pub const fn new(columns: usize, text: f64) -> Self {
        let (letters, background) = (Letters::Without, palette::PAPER);
        Self { columns, gap: 24, text, letters, title: String::new(), background }
    }

    /// The same figure with lettered captions.
    #[must_use]
    pub fn lettered(self) -> Self {
        Self { letters: Letters::With, ..self }
    }

    /// The same figure with a title.
    #[must_use]
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self { title: title.into(), ..self }
    }

    /// The figure. Columns are as wide as their widest picture, rows as high as their highest;
    /// pictures stand in the middle of their cells.
    ///
    /// # Errors
    /// [`DiagramError::Nothing`] without pictures, [`DiagramError::Size`] if the figure is too large.
    pub fn compose(&self, cells: &[Cell]) -> Result<Canvas, DiagramError> {
        if cells.is_empty() {
            return Err(DiagramError::Nothing { what: "a figure without pictures" });
        }
        let layout = Layout::new(self, cells);
        let mut page = Canvas::new(layout.width, layout.height, self.background)?;
        let title = TextStyle::new(1.15 * layout.text, palette::INK).anchored(Across::Middle, Down::Top);
        page.text(&self.title, DVec2::new(0.5 * f64::from(layout.width), f64::from(self.gap)), &title);
        for (i, cell) in cells.iter().enumerate() {
            let (column, row) = (i % layout.columns, i / layout.columns);
            let (left, top) = (layout.lefts[column], layout.tops[row]);
            let (wide, high) = (layout.widths[column], layout.heights[row]);
            let x = left + (wide - cell.picture.width()) / 2;
            let y = top + (high - cell.picture.height()) / 2;
            page.paste(&cell.picture, x as i32, y as i32);
            let style = TextStyle::new(layout.text, palette::INK).anchored(Across::Middle, Down::Top);
            for (line, words) in layout.captions[i].iter().enumerate() {
                let down = f64::from(top + high) + layout.text * (0.6 + 1.35 * line as f64);
                page.text(words, DVec2::new(f64::from(left) + 0.5 * f64::from(wide), down), &style);
            }
        }
        Ok(page)
    }
}

/// Where everything of a figure stands, in pixels.
struct Layout {
    columns: usize,
    text: f64,
    width: u32,
    height: u32,
    lefts: Vec<u32>,
    widths: Vec<u32>,
    tops: Vec<u32>,
    heights: Vec<u32>,
    /// The lines of each caption.
    captions: Vec<Vec<String>>,
}

impl Layout {
    fn new(grid: &Grid, cells: &[Cell]) -> Self {
        let columns = grid.columns.clamp(1, cells.len());
        let text = if grid.text.is_finite() { grid.text.clamp(4.0, 200.0) } else { 24.0 };
        let mut widths = vec![0; columns];
        for (i, cell) in cells.iter().enumerate() {
            widths[i % columns] = widths[i % columns].max(cell.picture.width());
        }
        let caption = |(i, cell): (usize, &Cell)| {
            let words = match grid.letters {
                Letters::With => format!("({}) {}", letter(i), cell.caption),
                Letters::Without => cell.caption.clone(),
            };
            break_lines(words.trim(), text, f64::from(widths[i % columns]))
        };
        let captions: Vec<Vec<String>> = cells.iter().enumerate().map(caption).collect();
        let head = if grid.title.is_empty() { 0 } else { (2.2 * text).ceil() as u32 };
        let mut tops = Vec::new();
        let mut heights = Vec::new();
        let mut below = grid.gap.saturating_add(head);
        for (row, lines) in cells.chunks(columns).zip(captions.chunks(columns)) {
            let high = row.iter().map(|cell| cell.picture.height()).max().unwrap_or(0);
            let most = lines.iter().map(Vec::len).max().unwrap_or(0);
            let words = if most == 0 { 0.0 } else { text * (0.8 + 1.35 * most as f64) };
            tops.push(below);
            heights.push(high);
            below = below.saturating_add(high).saturating_add(words.ceil() as u32).saturating_add(grid.gap);
        }
        let mut lefts = Vec::new();
        let mut right = grid.gap;
        for &wide in &widths {
            lefts.push(right);
            right = right.saturating_add(wide).saturating_add(grid.gap);
        }
        Self { columns, text, width: right, height: below, lefts, widths, tops, heights, captions }
    }
}

/// a to z, then aa, ab and so on.
fn letter(mut i: usize) -> String {
    let mut letters = String::new();
    loop {
        letters.insert(0, char::from(b'a' + (i % 26) as u8));
        if i < 26 {
            return letters;
        }
        i = i / 26 - 1;
    }
}

/// Breaks words into as few lines no wider than `most` pixels as they need, about equally long; a
/// line break in the text is kept.
fn break_lines(words: &str, text: f64, most: f64) -> Vec<String> {
    let fewest = fill_lines(words, text, most);
    let mut balanced = fewest.clone();
    let mut width = most;
    while width > text {
        width -= 0.5 * text;
        let narrower = fill_lines(words, text, width);
        let widest = narrower.iter().map(|line| text_width(line, text)).fold(0.0, f64::max);
        if narrower.len() > fewest.len() || widest > most {
            break;
        }
        balanced = narrower;
    }
    balanced
}

/// Lines that are each filled up to `most` pixels; a word wider than that has its own. A number stays
/// with the unit that follows it.
fn fill_lines(words: &str, text: f64, most: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in words.lines() {
        let mut line = String::new();
        for word in paragraph.split_inclusive(' ').collect::<Vec<_>>().chunk_by(|word, _| is_number(word)) {
            let word = word.concat();
            let longer = format!("{line}{word}");
            if line.is_empty() || text_width(longer.trim_end(), text) <= most {
                line = longer;
            } else {
                lines.push(core::mem::replace(&mut line, word).trim_end().to_owned());
            }
        }
        lines.push(line.trim_end().to_owned());
    }
    lines
}

fn is_number(word: &str) -> bool {
    let word = word.trim_end();
    word.ends_with(|c: char| c.is_ascii_digit()) && word.chars().all(|c| !c.is_alphabetic())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(width: u32, height: u32, code: u32) -> Canvas {
        Canvas::new(width, height, Colour::hex(code)).expect("a small picture")
    }

    #[test]
    fn every_picture_keeps_all_its_pixels() {
        let cells: Vec<Cell> =
            (1..=5).map(|i| Cell::new(block(30 + 7 * i, 20 + 3 * i, 0x10 * i), "a caption")).collect();
        let page = Grid::new(3, 12.0).lettered().titled("title").compose(&cells).expect("a small figure");
        for (i, cell) in (1_u8..).zip(&cells) {
            let shown = page.bytes().chunks_exact(4).filter(|p| **p == [0, 0, 0x10 * i, 255]).count();
            assert_eq!(shown as u32, cell.picture.width() * cell.picture.height(), "picture {i}");
        }
    }

    #[test]
    fn captions_break_between_words_and_stay_in_their_column() {
        let words = "level 3 of the octant, largest error in micrometres";
        let lines = break_lines(words, 14.0, 150.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| text_width(line, 14.0) <= 150.0));
        assert_eq!(lines.join(" "), words);
        let widths: Vec<f64> = lines.iter().map(|line| text_width(line, 14.0)).collect();
        assert!(widths.iter().all(|width| *width > 75.0), "no line is left with a word or two: {widths:?}");
    }

    #[test]
    fn a_number_stays_with_its_unit() {
        for most in 10..400 {
            let lines = break_lines("the arcs are met, the sphere is missed by 112 mm", 14.0, f64::from(most));
            assert!(lines.iter().any(|line| line.contains("112 mm")), "{most}: {lines:?}");
        }
    }

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!([0, 25, 26, 51, 52, 701, 702].map(letter), ["a", "z", "aa", "az", "ba", "zz", "aaa"]);
    }

    #[test]
    fn an_odd_layout_is_taken_or_refused_but_never_panics() {
        let one = [Cell::new(block(3, 3, 0), "")];
        assert!(matches!(Grid::new(3, 12.0).compose(&[]), Err(DiagramError::Nothing { .. })));
        for columns in [0, 1, usize::MAX] {
            assert!(Grid::new(columns, f64::NAN).compose(&one).is_ok());
        }
        assert!(Grid { gap: u32::MAX, ..Grid::new(1, 12.0) }.compose(&one).is_err());
    }
}
