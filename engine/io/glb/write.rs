//! GLB out.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Accessor, Index, Material, Mesh, Node, Root, Scene, Value, buffer};
use selvedge_components::triangles::Triangles;
use serde_json::value::to_raw_value;

use crate::io::check::{WriteError, check};

/// One object of a GLB file.
#[derive(Clone, Copy, Debug)]
pub struct Object<'a> {
    /// Its name, of the node and of the mesh.
    pub name: &'a str,
    /// Its triangles, normals and colours.
    pub surface: &'a Triangles,
    /// JSON to be kept with it, for numbers that single precision cannot hold.
    pub extras: Option<&'a Value>,
}

/// A GLB file in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Glb {
    /// The file.
    pub bytes: Vec<u8>,
    /// What became of each object.
    pub objects: Vec<ObjectReport>,
}

/// How an object stands in a GLB file.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectReport {
    /// The name of the object.
    pub name: String,
    /// The point about which its positions are given, in model units: the translation of its node.
    pub centre: DVec3,
    /// The largest distance between a position and what the file holds for it, in model units.
    pub error: f64,
}

/// Writes objects to a GLB file.
///
/// Positions are kept in single precision about the centre of each object, which its node's
/// translation holds, so that rounding is relative to the size of an object and not to its distance
/// from the origin. A normal of length zero becomes +z: the format asks for unit vectors. Colours are
/// linear.
///
/// # Errors
/// [`WriteError`] when an object is not what [`Triangles`] promises, has no triangles, or cannot be
/// expressed in the format.
pub fn write(objects: &[Object<'_>]) -> Result<Glb, WriteError> {
    if objects.is_empty() {
        return Err(WriteError::NoObjects);
    }
    let mut writer = Writer::default();
    let mut reports = Vec::with_capacity(objects.len());
    for object in objects {
        reports.push(writer.add(object)?);
    }
    Ok(Glb { bytes: writer.finish()?, objects: reports })
}

#[derive(Default)]
struct Writer {
    root: Root,
    buffer: Vec<u8>,
    nodes: Vec<Index<Node>>,
}

impl Writer {
    fn add(&mut self, object: &Object<'_>) -> Result<ObjectReport, WriteError> {
        let Object { name, surface, extras } = *object;
        check(surface)?;
        if surface.triangles.is_empty() {
            return Err(WriteError::Empty { object: name.to_owned() });
        }
        let extras = extras
            .map(to_raw_value)
            .transpose()
            .map_err(|why| WriteError::Extras { object: name.to_owned(), reason: why.to_string() })?;
        let centre = centre_of(&surface.positions);
        let (local, error) = about(centre, &surface.positions)?;
        let primitive = self.primitive(&local, surface);
        let name = name.to_owned();
        let mesh = self.root.push(Mesh {
            name: Some(name.clone()),
            primitives: vec![primitive],
            extensions: None,
            extras: None,
            weights: None,
        });
        let translation = Some(centre.to_array());
        let node = Node { name: Some(name.clone()), mesh: Some(mesh), translation, extras, ..Node::default() };
        self.nodes.push(self.root.push(node));
        Ok(ObjectReport { name, centre: centre.as_dvec3(), error })
    }

    fn primitive(&mut self, local: &[Vec3], surface: &Triangles) -> Primitive {
        let triples = |of: &mut Self, values: &[Vec3]| {
            let bytes = values.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes);
            of.accessor(bytes, values.len(), ComponentType::F32, Type::Vec3)
        };
        let positions = triples(self, local);
        let (low, high) = local.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let accessor = &mut self.root.accessors[positions.value()];
        accessor.min = Some(Value::from(low.to_array().to_vec()));
        accessor.max = Some(Value::from(high.to_array().to_vec()));
        let mut attributes = BTreeMap::from([(Valid(Semantic::Positions), positions)]);
        if !surface.normals.is_empty() {
            let unit = |n: &DVec3| n.normalize_or(DVec3::Z).as_vec3();
            let normals: Vec<Vec3> = surface.normals.iter().map(unit).collect();
            attributes.insert(Valid(Semantic::Normals), triples(self, &normals));
        }
        if !surface.colours.is_empty() {
            let clamped = |&c: &[f32; 3]| Vec3::from_array(c).clamp(Vec3::ZERO, Vec3::ONE);
            let colours: Vec<Vec3> = surface.colours.iter().map(clamped).collect();
            attributes.insert(Valid(Semantic::Colors(0)), triples(self, &colours));
        }
        let corners = surface.triangles.as_flattened();
        let bytes = corners.iter().flat_map(|index| index.to_le_bytes());
        let indices = self.accessor(bytes, corners.len(), ComponentType::U32, Type::Scalar);
        Primitive {
            attributes,
            indices: Some(indices),
            material: Some(Index::new(0)),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        }
    }

    /// Adds numbers to the buffer, in a view and an accessor of their own. All are of four bytes, so
    /// every view begins at a multiple of four, as it must.
    fn accessor(
        &mut self,
        bytes: impl Iterator<Item = u8>,
        count: usize,
        component: ComponentType,
        kind: Type,
    ) -> Index<Accessor> {
        let begin = self.buffer.len();
        self.buffer.extend(bytes);
        let target = match kind {
            Type::Scalar => buffer::Target::ElementArrayBuffer,
            _ => buffer::Target::ArrayBuffer,
        };
        let view = self.root.push(buffer::View {
            buffer: Index::new(0),
            byte_length: USize64::from(self.buffer.len() - begin),
            byte_offset: Some(USize64::from(begin)),
            byte_stride: None,
            name: None,
            target: Some(Valid(target)),
            extensions: None,
            extras: None,
        });
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(component)),
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: None,
        })
    }

    fn finish(mut self) -> Result<Vec<u8>, WriteError> {
        self.root.asset.generator = Some(concat!("selvedge ", env!("CARGO_PKG_VERSION")).to_owned());
        self.root.materials.push(plain_material());
        self.root.buffers.push(buffer::Buffer {
            byte_length: USize64::from(self.buffer.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let scene = Scene { nodes: self.nodes, name: None, extensions: None, extras: None };
        self.root.scene = Some(self.root.push(scene));
        // By way of a value, numbers are written with the decimals of a double. Those mean the same to
        // readers in single and in double precision; the shorter ones that would do for the former
        // would put an object far from the origin elsewhere for the latter.
        let json = self.root.to_value().map_err(std::io::Error::from)?.to_string().into_bytes();
        // Header, two chunk headers and the padding of either chunk.
        const FRAME: u64 = 12 + 2 * 8 + 2 * 3;
        let (bytes, limit) = (json.len() as u64 + self.buffer.len() as u64 + FRAME, u64::from(u32::MAX));
        if bytes > limit {
            return Err(WriteError::TooLong { bytes, limit });
        }
        let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
        let glb = gltf::binary::Glb { header, json: json.into(), bin: Some(self.buffer.into()) };
        glb.to_vec().map_err(|why| WriteError::Io(std::io::Error::other(why)))
    }
}

/// Dull, seen from both sides, and coloured by its vertices.
fn plain_material() -> Material {
    use gltf_json::material::{PbrMetallicRoughness, StrengthFactor};
    Material {
        double_sided: true,
        pbr_metallic_roughness: PbrMetallicRoughness {
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(0.75),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

/// The middle of the bounding box.
fn centre_of(positions: &[DVec3]) -> Vec3 {
    let bounds = positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    // Halved first: the sum of two doubles may overflow.
    (0.5 * bounds.0 + 0.5 * bounds.1).as_vec3()
}

/// Positions about a centre in single precision, and the largest distance that rounding has moved
/// one.
fn about(centre: Vec3, positions: &[DVec3]) -> Result<(Vec<Vec3>, f64), WriteError> {
    let centre = centre.as_dvec3();
    let mut error: f64 = 0.0;
    let mut local = Vec::with_capacity(positions.len());
    for (vertex, &at) in positions.iter().enumerate() {
        let rounded = (at - centre).as_vec3();
        if !rounded.is_finite() {
            return Err(WriteError::Beyond { vertex, at });
        }
        error = error.max((centre + rounded.as_dvec3()).distance(at));
        local.push(rounded);
    }
    Ok((local, error))
}
