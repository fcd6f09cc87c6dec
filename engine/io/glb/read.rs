//! GLB in.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DMat4, DVec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Node, Root};

use super::GlbError;
use super::accessor::Source;
use super::scene::{Placed, placed_meshes};
use crate::io::limits::{self, Limits};
use crate::io::polygons::{Polygons, PrimitivePlace};

/// Which vertices at one place become one.
///
/// GLB keeps one normal, one colour and one texture coordinate a vertex, so its writers split a
/// vertex wherever these differ, and the surface comes apart along every seam of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Weld {
    /// None.
    Never,
    /// Those of one object (node), which puts the splits of its writer together again and keeps
    /// objects apart that only touch.
    #[default]
    WithinObjects,
    /// All.
    Everywhere,
}

/// Reads the triangles of the default scene of a GLB file, all objects together, placed by their
/// nodes.
///
/// Positions are single precision in the file; transforms are applied in double. Vertices are welded
/// where their positions are the same bits. Vertices that no triangle of their primitive names are
/// left out: primitives may share one list.
///
/// # Errors
/// [`GlbError`] at the first thing that is wrong: every index, offset and count is checked before it
/// is used, and nothing is allocated for a claim that the file does not back. What the triangles
/// amount to is for [`Cage::from_polygons`](crate::io::Cage::from_polygons) to judge.
pub fn read(bytes: &[u8], limits: &Limits, weld: Weld) -> Result<Polygons, GlbError> {
    let (root, buffer) = open(bytes, limits)?;
    let source = Source { root: &root, buffer: &buffer };
    let (known, out) = (HashMap::new(), Polygons::default());
    let mut merger = Merger { source, limits: *limits, weld, known, corners: 0, out };
    for object in placed_meshes(&root)? {
        merger.add(object)?;
    }
    merger.out.reading.skipped = skipped(&root);
    Ok(merger.out)
}

/// JSON that a node carries beside its geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Extras {
    /// The name of the node, if it has one.
    pub name: Option<String>,
    /// What it carries.
    pub value: serde_json::Value,
}

/// Reads the extras of all nodes that have any, in the order of the nodes.
///
/// # Errors
/// [`GlbError`] when the container or its JSON cannot be read.
pub fn extras(bytes: &[u8], limits: &Limits) -> Result<Vec<Extras>, GlbError> {
    let (root, _) = open(bytes, limits)?;
    let carried = |node: &Node| {
        let value = serde_json::from_str(node.extras.as_ref()?.get()).ok()?;
        Some(Extras { name: node.name.clone(), value })
    };
    Ok(root.nodes.iter().filter_map(carried).collect())
}

/// Takes the container apart.
fn open<'a>(bytes: &'a [u8], limits: &Limits) -> Result<(Root, std::borrow::Cow<'a, [u8]>), GlbError> {
    limits::check("bytes", bytes.len(), limits.bytes)?;
    // The framing below subtracts the header from the length that it claims, whatever that is.
    let Some(&[.., a, b, c, d]) = bytes.first_chunk::<12>() else {
        return Err(GlbError::NoHeader { length: bytes.len() });
    };
    let claimed = u32::from_le_bytes([a, b, c, d]);
    let container = |reason: String| GlbError::Container { reason };
    if !bytes.starts_with(b"glTF") {
        return Err(container("it does not begin with \"glTF\"".to_owned()));
    }
    if (claimed as usize) < 12 || claimed as usize > bytes.len() {
        return Err(GlbError::Length { claimed, length: bytes.len() });
    }
    let glb = gltf::binary::Glb::from_slice(&bytes[..claimed as usize]).map_err(|why| container(why.to_string()))?;
    let root = Root::from_slice(&glb.json).map_err(|why| GlbError::Json {
        line: why.line(),
        column: why.column(),
        reason: why.to_string(),
    })?;
    refuse_extensions(&root)?;
    Ok((root, glb.bin.unwrap_or_default()))
}

/// Extensions that a file cannot be understood without are refused, unless they only say how it is
/// to look.
fn refuse_extensions(root: &Root) -> Result<(), GlbError> {
    const OF_LOOKS: [&str; 4] = ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"];
    let needed = root.extensions_required.iter().find(|name| !OF_LOOKS.iter().any(|looks| name.starts_with(looks)));
    let refuse =
        |name: &String| GlbError::Unsupported { place: "the file".to_owned(), what: format!("extension {name}") };
    needed.map_or(Ok(()), |name| Err(refuse(name)))
}

/// What the file has besides triangles that stand still.
fn skipped(root: &Root) -> Vec<(String, usize)> {
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let counts = [
        ("GLB skin", root.skins.len()),
        ("GLB animation", root.animations.len()),
        ("GLB primitive with morph targets", primitives().filter(|p| p.targets.is_some()).count()),
        ("GLB primitive of points or lines", primitives().filter(|p| !has_triangles(p)).count()),
    ];
    counts.into_iter().filter(|&(_, count)| count > 0).map(|(what, count)| (what.to_owned(), count)).collect()
}

fn has_triangles(primitive: &Primitive) -> bool {
    let modes = [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan].map(Checked::Valid);
    modes.contains(&primitive.mode)
}

/// Objects put together as they are read.
struct Merger<'a> {
    source: Source<'a>,
    limits: Limits,
    weld: Weld,
    /// The vertex at each place, by the bits of its position. Only looked up, never walked.
    known: HashMap<[u64; 3], u32>,
    /// How many corners have been read.
    corners: usize,
    out: Polygons,
}

impl Merger<'_> {
    fn add(&mut self, object: Placed) -> Result<(), GlbError> {
        if self.weld != Weld::Everywhere {
            self.known.clear();
        }
        let root = self.source.root;
        for (i, primitive) in root.meshes[object.mesh].primitives.iter().enumerate() {
            let place = PrimitivePlace { node: object.node, mesh: object.mesh, primitive: i };
            if let Checked::Invalid = primitive.mode {
                let what = "a primitive of an unknown mode".to_owned();
                return Err(GlbError::Unsupported { place: place.to_string(), what });
            }
            if has_triangles(primitive) {
                self.add_primitive(primitive, place, object.transform)?;
            }
        }
        Ok(())
    }

    fn add_primitive(&mut self, primitive: &Primitive, place: PrimitivePlace, at: DMat4) -> Result<(), GlbError> {
        let of = place.to_string();
        let attribute = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let &attribute = attribute.ok_or(GlbError::NoPositions { place })?;
        let positions = self.source.positions(&of, attribute)?;
        self.count_corners(self.source.claimed(primitive.indices.unwrap_or(attribute)))?;
        let corners = match primitive.indices {
            Some(indices) => self.source.indices(&of, indices)?,
            None => (0..positions.len() as u32).collect(),
        };
        let beyond = corners.iter().position(|&index| index as usize >= positions.len());
        if let Some(corner) = beyond {
            let vertex_count = positions.len();
            return Err(GlbError::IndexOutOfRange { place, corner, index: corners[corner], vertex_count });
        }
        let mut triangles = list_triangles(&corners, primitive.mode, place)?;
        if at.determinant() < 0.0 {
            // A mirrored object is seen from its inside (glTF 2.0, section 3.7.4).
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        self.out.reading.unreferenced += positions.len() - used.len();
        let mut names = Vec::with_capacity(used.len());
        for &vertex in &used {
            let point = at.transform_point3(DVec3::from_array(positions.get(vertex as usize).map(f64::from)));
            if !point.is_finite() {
                return Err(GlbError::NotFinite { place, vertex });
            }
            names.push(self.vertex(point)?);
        }
        limits::check("faces", self.out.face_count() + triangles.len(), self.limits.faces)?;
        self.out.begin_primitive(place);
        for triangle in triangles {
            let named = triangle.map(|vertex| names[used.partition_point(|&known| known < vertex)]);
            self.out.push(&named).expect("three corners");
        }
        Ok(())
    }

    /// The name of the vertex at a place, welded or new.
    fn vertex(&mut self, point: DVec3) -> Result<u32, GlbError> {
        let new = self.out.positions.len() as u32;
        if self.weld != Weld::Never {
            // Minus zero is the same place as zero.
            let key = point.to_array().map(|x| (x + 0.0).to_bits());
            match self.known.entry(key) {
                Entry::Occupied(there) => {
                    self.out.reading.welded += 1;
                    return Ok(*there.get());
                }
                Entry::Vacant(free) => free.insert(new),
            };
        }
        limits::check("vertices", self.out.positions.len() + 1, self.limits.vertices)?;
        self.out.positions.push(point);
        Ok(new)
    }

    /// Counts corners before they are read, also those of triangles without area that will be left
    /// out: nodes and primitives may name one accessor over and over.
    fn count_corners(&mut self, more: u64) -> Result<(), GlbError> {
        self.corners = self.corners.saturating_add(usize::try_from(more).unwrap_or(usize::MAX));
        Ok(limits::check("corners of triangles", self.corners, self.limits.faces.saturating_mul(3))?)
    }
}

/// The triangles of a list, a strip or a fan (glTF 2.0, section 3.7.2.1). Strips are joined by
/// triangles without area, which name a vertex twice; those are left out.
fn list_triangles(corners: &[u32], mode: Checked<Mode>, place: PrimitivePlace) -> Result<Vec<[u32; 3]>, GlbError> {
    let whole = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle;
        a != b && b != c && c != a
    };
    match mode {
        Checked::Valid(Mode::TriangleStrip) => {
            let turned = |(i, window): (usize, &[u32])| match i % 2 {
                0 => [window[0], window[1], window[2]],
                _ => [window[0], window[2], window[1]],
            };
            Ok(corners.windows(3).enumerate().map(turned).filter(whole).collect())
        }
        Checked::Valid(Mode::TriangleFan) => {
            let rim = corners.get(1..).unwrap_or_default();
            Ok(rim.windows(2).map(|pair| [pair[0], pair[1], corners[0]]).collect())
        }
        _ => {
            let (triangles, rest) = corners.as_chunks::<3>();
            if rest.is_empty() {
                Ok(triangles.to_vec())
            } else {
                Err(GlbError::Corners { place, count: corners.len() })
            }
        }
    }
}
