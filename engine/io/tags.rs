//! Sharpness tags: which vertices are corners, which edges are creases.
//!
//! The notation is that of OpenSubdiv's regression shapes: `name ints/floats/strings`, then as many
//! numbers of each kind. A tag file is a JSON list of such lines; in an OBJ file each stands after a
//! `t`. Vertices are counted from 0 in both.
//!
//! | tag | meaning |
//! | --- | --- |
//! | `interpolateboundary 1/0/0 1` | edge and corner: border vertices of one face are corners |
//! | `interpolateboundary 1/0/0 2` | edge only: no corners but those declared (the default) |
//! | `corner n/1/0 v.. s`, `corner n/n/0 v.. s..` | vertices with a sharpness |
//! | `crease 2n/1/0 a b.. s`, `crease 2n/n/0 a b.. s..` | edges, by their ends, with a sharpness |

use std::{fmt, str::SplitAsciiWhitespace};

use selvedge_components::mesh::{Connectivity, EdgeId, VertexId};
use thiserror::Error;

/// Sharpness from which a corner or crease stays sharp for good; the value that OpenSubdiv uses.
pub const INFINITELY_SHARP: f64 = 10.0;

/// What the tags of a cage ask for.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Tags {
    /// Corners by the shape of the border.
    pub border: BorderCorners,
    /// Corners by name.
    pub corners: Vec<Corner>,
    /// Creases.
    pub creases: Vec<Crease>,
    /// Tags of other kinds, as they stand in the file.
    pub other: Vec<String>,
}

/// Which border vertices are corners without being named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BorderCorners {
    /// None: the border is smooth ("edge only").
    #[default]
    Declared,
    /// Those of valence 2, which belong to one face only ("edge and corner").
    ValenceTwo,
}

/// A vertex that a tag sharpens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The vertex.
    pub vertex: VertexId,
    /// From 0 (smooth) up; [`INFINITELY_SHARP`] and above stays sharp for good.
    pub sharpness: f64,
}

/// An edge that a tag sharpens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crease {
    /// The ends of the edge.
    pub ends: [VertexId; 2],
    /// From 0 (smooth) up; [`INFINITELY_SHARP`] and above stays sharp for good.
    pub sharpness: f64,
}

/// What is wrong with a tag.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TagError {
    /// The file is not a JSON list of strings.
    #[error("line {line}, column {column}: the tags are not a JSON list of strings: {reason}")]
    Json {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the JSON reader says.
        reason: String,
    },
    /// The counts after the name are not `ints/floats/strings`.
    #[error("tag {tag:?}: {found:?} is not of the form ints/floats/strings")]
    Counts {
        /// The tag.
        tag: String,
        /// What stands where the counts should be.
        found: String,
    },
    /// The counts promise other values than follow, or other values than this kind of tag takes.
    #[error("tag {tag:?} has {found} values of a kind where {expected} are expected")]
    Values {
        /// The tag.
        tag: String,
        /// How many are expected.
        expected: String,
        /// How many there are.
        found: usize,
    },
    /// A value is not a vertex index or not a finite sharpness of at least 0.
    #[error("tag {tag:?}: {value:?} is not {expected}")]
    Value {
        /// The tag.
        tag: String,
        /// The value.
        value: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A tag names a vertex that does not exist.
    #[error("a tag names vertex {vertex}, but there are {vertex_count} vertices")]
    NoSuchVertex {
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A crease names two vertices that share no edge.
    #[error("a crease names vertices {} and {}, but no edge joins them", .ends[0], .ends[1])]
    NoSuchEdge {
        /// The vertices.
        ends: [VertexId; 2],
    },
}

impl Tags {
    /// Reads a tag file: a JSON list of strings, one tag each.
    ///
    /// # Errors
    /// [`TagError`] at the first tag that cannot be understood. Tags of unknown kinds are kept in
    /// [`Tags::other`] as they are.
    pub fn from_json(bytes: &[u8]) -> Result<Self, TagError> {
        let lines: Vec<String> = serde_json::from_slice(bytes).map_err(|why| TagError::Json {
            line: why.line(),
            column: why.column(),
            reason: why.to_string(),
        })?;
        let mut tags = Self::default();
        for line in &lines {
            tags.push(line)?;
        }
        Ok(tags)
    }

    /// Adds one tag in OpenSubdiv's notation.
    ///
    /// # Errors
    /// [`TagError`] when it cannot be understood.
    pub fn push(&mut self, tag: &str) -> Result<(), TagError> {
        let Some(parts) = Parts::split(tag)? else { return Ok(()) };
        match parts.name {
            "interpolateboundary" => match parts.integers[..] {
                ["1"] => self.border = BorderCorners::ValenceTwo,
                ["2"] => self.border = BorderCorners::Declared,
                // 0 leaves out the faces along the border, which is no property of a surface.
                _ => self.other.push(tag.to_owned()),
            },
            "corner" => {
                let vertices = parts.vertices()?;
                let sharpness = parts.sharpness(vertices.len())?;
                let pairs = vertices.into_iter().zip(sharpness);
                self.corners.extend(pairs.map(|(vertex, sharpness)| Corner { vertex, sharpness }));
            }
            "crease" => {
                let vertices = parts.vertices()?;
                let (edges, rest) = vertices.as_chunks::<2>();
                if !rest.is_empty() {
                    return Err(parts.miscounted("an even number", vertices.len()));
                }
                let sharpness = parts.sharpness(edges.len())?;
                let pairs = edges.iter().zip(sharpness);
                self.creases.extend(pairs.map(|(&ends, sharpness)| Crease { ends, sharpness }));
            }
            _ => self.other.push(tag.to_owned()),
        }
        Ok(())
    }

    /// Resolves the tags on a mesh: the border corners, ascending, and everything that is asked for
    /// but has no meaning for a combined Loop surface.
    pub(super) fn resolve(&self, mesh: &Connectivity) -> Result<(Vec<VertexId>, Vec<Unkept>), TagError> {
        self.check(mesh)?;
        let mut corners = Vec::new();
        let mut unkept: Vec<Unkept> = self.other.iter().cloned().map(Unkept::Tag).collect();
        for &corner in &self.corners {
            if corner.sharpness >= INFINITELY_SHARP && mesh.is_border(corner.vertex) {
                corners.push(corner.vertex);
            } else if corner.sharpness > 0.0 {
                unkept.push(Unkept::Corner(corner));
            }
        }
        if self.border == BorderCorners::ValenceTwo {
            let vertices = (0..mesh.vertex_count()).map(VertexId::new);
            corners.extend(vertices.filter(|&v| mesh.is_border(v) && mesh.valence(v) == 2));
        }
        corners.sort_unstable();
        corners.dedup();
        unkept.extend(self.creases.iter().filter(|crease| crease.sharpness > 0.0).copied().map(Unkept::Crease));
        Ok((corners, unkept))
    }

    fn check(&self, mesh: &Connectivity) -> Result<(), TagError> {
        let vertex_count = mesh.vertex_count();
        let named = self.corners.iter().map(|c| c.vertex).chain(self.creases.iter().flat_map(|c| c.ends));
        if let Some(vertex) = named.into_iter().find(|v| v.index() >= vertex_count) {
            return Err(TagError::NoSuchVertex { vertex, vertex_count });
        }
        if self.creases.is_empty() {
            return Ok(());
        }
        let ascending = |[a, b]: [VertexId; 2]| [a.min(b), a.max(b)];
        let halfedges = (0..mesh.edge_count()).map(|e| mesh.halfedge(EdgeId::new(e)));
        let mut edges: Vec<[VertexId; 2]> = halfedges.map(|h| ascending([mesh.from(h), mesh.to(h)])).collect();
        edges.sort_unstable();
        let missing = self.creases.iter().find(|crease| edges.binary_search(&ascending(crease.ends)).is_err());
        missing.map_or(Ok(()), |crease| Err(TagError::NoSuchEdge { ends: crease.ends }))
    }
}

/// Something a file asks for that the surface does not have.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Unkept {
    /// A corner inside the surface, or one that is to become smooth after some levels.
    Corner(Corner),
    /// A crease.
    Crease(Crease),
    /// A tag of another kind.
    Tag(String),
    /// Statements or features of the file, and how many of them.
    Skipped(String, usize),
}

impl fmt::Display for Unkept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Corner(Corner { vertex, sharpness }) => {
                write!(f, "a corner of sharpness {sharpness} at vertex {vertex}")
            }
            Self::Crease(Crease { ends: [a, b], sharpness }) => {
                write!(f, "a crease of sharpness {sharpness} along edge {a}-{b}")
            }
            Self::Tag(tag) => write!(f, "the tag {tag:?}"),
            Self::Skipped(what, 1) => f.write_str(what),
            Self::Skipped(what, count) => write!(f, "{what} ({count} times)"),
        }
    }
}

/// A tag in its parts.
struct Parts<'a> {
    tag: &'a str,
    name: &'a str,
    integers: Vec<&'a str>,
    floats: Vec<&'a str>,
}

impl<'a> Parts<'a> {
    /// `None` for an empty line.
    fn split(tag: &'a str) -> Result<Option<Self>, TagError> {
        let mut words = tag.split_ascii_whitespace();
        let Some(name) = words.next() else { return Ok(None) };
        let counts = words.next().unwrap_or("");
        let malformed = || TagError::Counts { tag: tag.to_owned(), found: counts.to_owned() };
        let numbers: Vec<usize> =
            counts.split('/').map(str::parse).collect::<Result<_, _>>().map_err(|_| malformed())?;
        let [integers, floats, strings] = numbers[..] else { return Err(malformed()) };
        let mut parts = Self { tag, name, integers: Vec::new(), floats: Vec::new() };
        parts.integers = parts.take(&mut words, integers)?;
        parts.floats = parts.take(&mut words, floats)?;
        parts.take(&mut words, strings)?;
        match words.count() {
            0 => Ok(Some(parts)),
            more => Err(parts.miscounted("no more", more)),
        }
    }

    /// The next `count` words. What is claimed is compared with what is there before it is stored.
    fn take(&self, words: &mut SplitAsciiWhitespace<'a>, count: usize) -> Result<Vec<&'a str>, TagError> {
        let taken: Vec<&str> = words.take(count).collect();
        if taken.len() < count { Err(self.miscounted(&count.to_string(), taken.len())) } else { Ok(taken) }
    }

    fn vertices(&self) -> Result<Vec<VertexId>, TagError> {
        let read = |word: &&str| word.parse().map(VertexId).map_err(|_| self.bad(word, "a vertex index"));
        self.integers.iter().map(read).collect()
    }

    /// One sharpness for each of `count` elements; a single one is for all.
    fn sharpness(&self, count: usize) -> Result<Vec<f64>, TagError> {
        let read = |word: &&str| match word.parse::<f64>() {
            Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
            _ => Err(self.bad(word, "a finite sharpness of at least 0")),
        };
        let values: Vec<f64> = self.floats.iter().map(read).collect::<Result<_, _>>()?;
        match values[..] {
            [all] => Ok(vec![all; count]),
            _ if values.len() == count => Ok(values),
            _ => Err(self.miscounted(&format!("1 or {count}"), values.len())),
        }
    }

    fn bad(&self, value: &str, expected: &'static str) -> TagError {
        TagError::Value { tag: self.tag.to_owned(), value: value.to_owned(), expected }
    }

    fn miscounted(&self, expected: &str, found: usize) -> TagError {
        TagError::Values { tag: self.tag.to_owned(), expected: expected.to_owned(), found }
    }
}
