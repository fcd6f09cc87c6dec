//! OBJ in.
//!
//! Read here and not by a crate: those at hand answer an error without its line, wrap a relative
//! index that reaches too far back round to a huge one, and cut polygons into fans before anything
//! could be said about valences.

use glam::DVec3;
use thiserror::Error;

use crate::io::limits::{self, Limits, TooLarge};
use crate::io::polygons::Polygons;
use crate::io::tags::{TagError, Tags};

/// Why an OBJ file is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file, or what it holds up to some line, is larger than it may be.
    #[error("{}{why}", at(*.line))]
    TooLarge {
        /// The line that goes too far; `None` for the file as a whole.
        line: Option<usize>,
        /// What there is too much of.
        why: TooLarge,
    },
    /// A line begins with something that is no statement of the format.
    #[error("line {line}: {keyword:?} is no OBJ statement")]
    Statement {
        /// The line, from 1.
        line: usize,
        /// What it begins with.
        keyword: String,
    },
    /// A vertex has too few or too many coordinates.
    #[error("line {line}: a vertex of {found} numbers; it takes 3 (position), 4 (and weight) or 6 (and colour)")]
    Coordinates {
        /// The line, from 1.
        line: usize,
        /// How many numbers there are.
        found: usize,
    },
    /// A coordinate is no number.
    #[error("line {line}: {token:?} is not a number")]
    Number {
        /// The line, from 1.
        line: usize,
        /// What stands there.
        token: String,
    },
    /// A coordinate is NaN or infinite, or too large for a double.
    #[error("line {line}: {token:?} is not finite")]
    NotFinite {
        /// The line, from 1.
        line: usize,
        /// What stands there.
        token: String,
    },
    /// A vertex has a weight, which belongs to rational curves and surfaces.
    #[error("line {line}: a vertex of weight {weight}; only weight 1 has a meaning for polygons")]
    Weight {
        /// The line, from 1.
        line: usize,
        /// The weight.
        weight: f64,
    },
    /// A corner of a face is not of the form `v`, `v/vt`, `v//vn` or `v/vt/vn` with integers that
    /// are not 0.
    #[error("line {line}: {token:?} is not a corner of a face")]
    Corner {
        /// The line, from 1.
        line: usize,
        /// What stands there.
        token: String,
    },
    /// A face names a vertex that does not exist.
    #[error("line {line}: a face names vertex {index}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The line, from 1.
        line: usize,
        /// The index as the file gives it: from 1, or below 0 counted back from the last vertex.
        index: i64,
        /// How many vertices the index may reach: all of the file, or for one below 0 those before
        /// this line.
        vertex_count: usize,
    },
    /// A face has fewer than three corners.
    #[error("line {line}: a face of {sides} sides")]
    TooFewSides {
        /// The line, from 1.
        line: usize,
        /// How many corners it has.
        sides: usize,
    },
    /// A `t` statement cannot be understood.
    #[error("line {line}: {why}")]
    Tag {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        why: TagError,
    },
}

fn at(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!("line {line}: "))
}

/// Statements that say nothing of polygons. Grouping and appearance pass without a word; the others
/// are reported with how often they stand in the file.
const SILENT: [&str; 7] = ["o", "g", "s", "mg", "usemtl", "mtllib", "usemap"];
const REPORTED: [&str; 35] = [
    "vt",
    "vn",
    "vp",
    "p",
    "l",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "maplib",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "bsp",
    "bzp",
    "cdc",
    "cdp",
    "res",
    "call",
    "csh",
];

/// Reads the polygons of an OBJ file, all its objects together.
///
/// Positions are read as doubles. Indices may be relative (below 0), corners may name texture and
/// normal indices, lines may end in `\` to go on on the next, or in a carriage return. `t` statements
/// are tags, see [`Tags`].
///
/// # Errors
/// [`ObjError`] at the first line that is wrong. What each index of a face may name is checked; what
/// the faces amount to is for [`Cage::from_polygons`](crate::io::Cage::from_polygons) to judge.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Polygons, ObjError> {
    limits::check("bytes", bytes.len(), limits.bytes).map_err(|why| ObjError::TooLarge { line: None, why })?;
    let mut reader = Reader { limits: *limits, ..Reader::default() };
    for_each_line(bytes, |line, text| reader.statement(line, text))?;
    reader.finish()
}

/// Calls `visit` with every logical line and the number of its first physical one. A comment does
/// not go on: what ends in a backslash there is a path, and the next line would be lost.
fn for_each_line(bytes: &[u8], mut visit: impl FnMut(usize, &[u8]) -> Result<(), ObjError>) -> Result<(), ObjError> {
    const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let mut joined: Option<(usize, Vec<u8>)> = None;
    for (i, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let is_comment = joined.is_none() && line.trim_ascii_start().starts_with(b"#");
        let begun = if is_comment { None } else { line.strip_suffix(b"\\") };
        match (joined.take(), begun) {
            (None, None) => visit(i + 1, line)?,
            (None, Some(begun)) => joined = Some((i + 1, [begun, b" "].concat())),
            (Some((first, mut text)), rest) => {
                text.extend_from_slice(rest.unwrap_or(line));
                if rest.is_some() {
                    text.push(b' ');
                    joined = Some((first, text));
                } else {
                    visit(first, &text)?;
                }
            }
        }
    }
    joined.map_or(Ok(()), |(first, text)| visit(first, &text))
}

#[derive(Default)]
struct Reader {
    limits: Limits,
    positions: Vec<DVec3>,
    polygons: Polygons,
    tags: Tags,
    skipped: Vec<(&'static str, usize)>,
    vertex_lines: Vec<usize>,
    face_lines: Vec<usize>,
    /// Corners of the face being read.
    corners: Vec<u32>,
}

impl Reader {
    fn statement(&mut self, line: usize, text: &[u8]) -> Result<(), ObjError> {
        let text = text.split(|&b| b == b'#').next().unwrap_or_default();
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            b"v" => self.vertex(line, words),
            b"f" | b"fo" => self.face(line, words),
            b"t" => {
                let tag = String::from_utf8_lossy(&text.trim_ascii_start()[1..]).into_owned();
                self.tags.push(&tag).map_err(|why| ObjError::Tag { line, why })
            }
            other => self.skip(line, other),
        }
    }

    fn vertex<'a>(&mut self, line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<(), ObjError> {
        let mut numbers = [0.0; 6];
        let mut found = 0;
        for word in words {
            if let Some(number) = numbers.get_mut(found) {
                *number = coordinate(line, word)?;
            }
            found += 1;
        }
        let [x, y, z, weight, ..] = numbers;
        match found {
            4 if weight != 1.0 => return Err(ObjError::Weight { line, weight }),
            3 | 4 | 6 => {}
            _ => return Err(ObjError::Coordinates { line, found }),
        }
        self.refuse_more("vertices", line, self.positions.len() + 1, self.limits.vertices)?;
        self.positions.push(DVec3::new(x, y, z));
        self.vertex_lines.push(line);
        Ok(())
    }

    fn face<'a>(&mut self, line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<(), ObjError> {
        self.corners.clear();
        for word in words {
            self.refuse_more("sides of a face", line, self.corners.len() + 1, self.limits.sides)?;
            let corner = self.corner(line, word)?;
            self.corners.push(corner);
        }
        self.refuse_more("faces", line, self.face_lines.len() + 1, self.limits.faces)?;
        let sides = self.corners.len();
        self.polygons.push(&self.corners).map_err(|_| ObjError::TooFewSides { line, sides })?;
        self.face_lines.push(line);
        Ok(())
    }

    /// The vertex that a corner names, from 0. One above 0 may come later in the file, and is checked
    /// at its end.
    fn corner(&self, line: usize, word: &[u8]) -> Result<u32, ObjError> {
        let malformed = || ObjError::Corner { line, token: shown(word) };
        let mut parts = word.split(|&b| b == b'/');
        let index = integer(parts.next().unwrap_or_default()).ok_or_else(malformed)?;
        let (texture, normal) = (parts.next(), parts.next());
        let no_index = |part: Option<&[u8]>| part.is_some_and(|p| !p.is_empty() && integer(p).is_none());
        if index == 0 || no_index(texture) || no_index(normal) || parts.next().is_some() {
            return Err(malformed());
        }
        let so_far = self.positions.len();
        let vertex = if index > 0 { index - 1 } else { index.saturating_add(so_far as i64) };
        // The last id is kept for "none"; `Limits` is far below it unless a caller has raised it.
        match u32::try_from(vertex) {
            Ok(vertex) if vertex < u32::MAX => Ok(vertex),
            _ => Err(ObjError::IndexOutOfRange { line, index, vertex_count: so_far }),
        }
    }

    fn skip(&mut self, line: usize, keyword: &[u8]) -> Result<(), ObjError> {
        if SILENT.iter().any(|name| name.as_bytes() == keyword) {
            return Ok(());
        }
        let Some(&name) = REPORTED.iter().find(|name| name.as_bytes() == keyword) else {
            return Err(ObjError::Statement { line, keyword: shown(keyword) });
        };
        match self.skipped.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => self.skipped.push((name, 1)),
        }
        Ok(())
    }

    fn refuse_more(&self, what: &'static str, line: usize, count: usize, limit: usize) -> Result<(), ObjError> {
        limits::check(what, count, limit).map_err(|why| ObjError::TooLarge { line: Some(line), why })
    }

    fn finish(mut self) -> Result<Polygons, ObjError> {
        let vertex_count = self.positions.len();
        for (face, &line) in self.polygons.faces().zip(&self.face_lines) {
            if let Some(&beyond) = face.iter().find(|&&v| v as usize >= vertex_count) {
                return Err(ObjError::IndexOutOfRange { line, index: i64::from(beyond) + 1, vertex_count });
            }
        }
        self.polygons.positions = self.positions;
        self.polygons.tags = self.tags;
        let name = |(keyword, count): (&str, usize)| (format!("OBJ statement {keyword:?}"), count);
        self.polygons.reading.skipped = self.skipped.into_iter().map(name).collect();
        self.polygons.set_lines(self.vertex_lines, self.face_lines);
        Ok(self.polygons)
    }
}

fn coordinate(line: usize, word: &[u8]) -> Result<f64, ObjError> {
    match std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok()) {
        Some(number) if number.is_finite() => Ok(number),
        Some(_) => Err(ObjError::NotFinite { line, token: shown(word) }),
        None => Err(ObjError::Number { line, token: shown(word) }),
    }
}

fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The beginning of a word, fit to be printed.
fn shown(word: &[u8]) -> String {
    const SHOWN: usize = 32;
    String::from_utf8_lossy(&word[..word.len().min(SHOWN)]).into_owned()
}
