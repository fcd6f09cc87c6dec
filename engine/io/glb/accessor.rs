//! Numbers in the buffer, read within bounds that were checked.

use gltf_json::accessor::{ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index, Root, buffer};

use super::GlbError;

/// A scene and the buffer that its accessors look into.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) root: &'a Root,
    pub(super) buffer: &'a [u8],
}

/// The elements of an accessor: `count` of them, `stride` bytes apart, the last of `size` bytes.
#[derive(Clone, Copy)]
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    pub(super) fn len(&self) -> usize {
        self.count
    }

    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..i * self.stride + self.size]
    }

    fn iter(self) -> impl ExactSizeIterator<Item = &'a [u8]> {
        (0..self.count).map(move |i| self.get(i))
    }
}

/// Positions as a file holds them.
#[derive(Clone, Copy)]
pub(super) struct Positions<'a>(Elements<'a>);

impl Positions<'_> {
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Position `i`, which must be below [`Self::len`].
    pub(super) fn get(&self, i: usize) -> [f32; 3] {
        let bytes = self.0.get(i);
        let at = |k: usize| f32::from_le_bytes(std::array::from_fn(|j| bytes[4 * k + j]));
        [at(0), at(1), at(2)]
    }
}

impl<'a> Source<'a> {
    /// The positions of an accessor, which must be triples of single precision.
    pub(super) fn positions(self, of: &str, index: Index<Accessor>) -> Result<Positions<'a>, GlbError> {
        self.elements(of, index, "positions (three floats)", |component, kind| {
            (component == ComponentType::F32 && kind == Type::Vec3).then_some(12)
        })
        .map(|(elements, _)| Positions(elements))
    }

    /// How many elements an accessor claims to have, before anything is believed.
    pub(super) fn claimed(self, index: Index<Accessor>) -> u64 {
        self.root.accessors.get(index.value()).map_or(0, |accessor| accessor.count.0)
    }

    /// The indices of an accessor, which must be unsigned integers.
    pub(super) fn indices(self, of: &str, index: Index<Accessor>) -> Result<Vec<u32>, GlbError> {
        let (elements, component) = self.elements(of, index, "indices (unsigned integers)", |component, kind| {
            let unsigned = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
            (unsigned && kind == Type::Scalar).then(|| component.size())
        })?;
        let read = |bytes: &[u8]| match (component, bytes) {
            (ComponentType::U8, &[a]) => u32::from(a),
            (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (_, bytes) => u32::from_le_bytes(std::array::from_fn(|j| bytes[j])),
        };
        Ok(elements.iter().map(read).collect())
    }

    /// The elements of an accessor. `size` gives the bytes of one, or refuses the type.
    fn elements(
        self,
        of: &str,
        index: Index<Accessor>,
        expected: &'static str,
        size: impl Fn(ComponentType, Type) -> Option<usize>,
    ) -> Result<(Elements<'a>, ComponentType), GlbError> {
        let place = || format!("accessor {}", index.value());
        let accessor = named(&self.root.accessors, "accessor", index.value(), of)?;
        let wrong_type = |found: String| GlbError::Type { accessor: index.value(), expected, found };
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err(wrong_type("an unknown type".to_owned()));
        };
        let component = component.0;
        let size = size(component, kind).ok_or_else(|| wrong_type(format!("{kind:?} of {component:?}")))?;
        let Some(view) = accessor.buffer_view.filter(|_| accessor.sparse.is_none()) else {
            return Err(GlbError::Unsupported { place: place(), what: "a sparse accessor".to_owned() });
        };
        let (view_bytes, stride) = self.view(&place(), view)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(GlbError::Stride { accessor: index.value(), size, stride });
        }
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let span = match accessor.count.0 {
            0 => 0,
            count => (count - 1).saturating_mul(stride as u64).saturating_add(size as u64),
        };
        let end = offset.saturating_add(span);
        let holder = || format!("buffer view {}", view.value());
        let bytes = slice(view_bytes, offset, end, &place, &holder)?;
        // What fits into the file fits into a usize.
        let count = accessor.count.0 as usize;
        Ok((Elements { bytes, stride, size, count }, component))
    }

    /// The bytes of a buffer view and the stride that it sets, if any.
    fn view(self, of: &str, index: Index<buffer::View>) -> Result<(&'a [u8], Option<usize>), GlbError> {
        let view = named(&self.root.buffer_views, "buffer view", index.value(), of)?;
        let place = || format!("buffer view {}", index.value());
        let buffer = named(&self.root.buffers, "buffer", view.buffer.value(), &place())?;
        if view.buffer.value() != 0 || buffer.uri.is_some() {
            let what = format!("buffer {} outside the file", view.buffer.value());
            return Err(GlbError::Unsupported { place: place(), what });
        }
        // The chunk may be longer than the buffer by its padding, never shorter.
        let buffer_bytes =
            slice(self.buffer, 0, buffer.byte_length.0, &|| "buffer 0".to_owned(), &|| "the file".to_owned())?;
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        let end = offset.saturating_add(view.byte_length.0);
        let bytes = slice(buffer_bytes, offset, end, &place, &|| "buffer 0".to_owned())?;
        // Some writers say 0 where they mean "side by side".
        Ok((bytes, view.byte_stride.map(|stride| stride.0).filter(|&stride| stride != 0)))
    }
}

/// `bytes[begin..end]`, or who claims what.
fn slice<'a>(
    bytes: &'a [u8],
    begin: u64,
    end: u64,
    place: &dyn Fn() -> String,
    holder: &dyn Fn() -> String,
) -> Result<&'a [u8], GlbError> {
    let range = usize::try_from(begin).ok().zip(usize::try_from(end).ok());
    let found = range.and_then(|(begin, end)| bytes.get(begin..end));
    let held = bytes.len() as u64;
    found.ok_or_else(|| GlbError::Overrun { place: place(), claimed: end, holder: holder(), held })
}

/// The element of that index, or who names one that does not exist.
pub(super) fn named<'a, T>(all: &'a [T], what: &'static str, index: usize, place: &str) -> Result<&'a T, GlbError> {
    all.get(index).ok_or_else(|| GlbError::NoSuch { place: place.to_owned(), what, index, count: all.len() })
}
