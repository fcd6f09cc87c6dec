//! Why a GLB file is refused.

use thiserror::Error;

use crate::io::limits::TooLarge;
use crate::io::polygons::PrimitivePlace;

/// Why a GLB file is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The file is larger than it may be.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// The file ends within its header of 12 bytes.
    #[error("{length} bytes are no GLB file: its header takes 12")]
    NoHeader {
        /// How long the file is.
        length: usize,
    },
    /// The header gives another length than the file has.
    #[error("the header says {claimed} bytes, the file has {length}")]
    Length {
        /// What the header says.
        claimed: u32,
        /// How long the file is.
        length: usize,
    },
    /// The chunks are not those of a GLB file.
    #[error("not a GLB container: {reason}")]
    Container {
        /// What is wrong.
        reason: String,
    },
    /// The scene is not the JSON of a glTF file.
    #[error("JSON chunk, line {line}, column {column}: {reason}")]
    Json {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the JSON reader says.
        reason: String,
    },
    /// An element names another that does not exist.
    #[error("{place} names {what} {index}, but there are {count}")]
    NoSuch {
        /// The element that names.
        place: String,
        /// What kind of element is named.
        what: &'static str,
        /// Its index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A node is reached twice: the nodes are no forest.
    #[error("node {node} is reached by more than one way: nodes must form trees")]
    NotATree {
        /// The node.
        node: usize,
    },
    /// The file needs something that is not read here.
    #[error("{place}: {what} is not supported")]
    Unsupported {
        /// The element that needs it.
        place: String,
        /// What it needs.
        what: String,
    },
    /// An element reaches beyond what holds it.
    #[error("{place} claims {claimed} bytes, but {holder} holds {held}")]
    Overrun {
        /// The element.
        place: String,
        /// How many bytes it needs, from the beginning of what holds it.
        claimed: u64,
        /// What holds it.
        holder: String,
        /// How many bytes that has.
        held: u64,
    },
    /// An accessor has elements of another type than its use asks for.
    #[error("accessor {accessor} holds {found} where {expected} are expected")]
    Type {
        /// The accessor.
        accessor: usize,
        /// What is expected.
        expected: &'static str,
        /// What it holds.
        found: String,
    },
    /// The elements of an accessor overlap.
    #[error("accessor {accessor} has elements of {size} bytes every {stride}")]
    Stride {
        /// The accessor.
        accessor: usize,
        /// Bytes of one element.
        size: usize,
        /// Bytes from one element to the next.
        stride: usize,
    },
    /// A primitive has no positions.
    #[error("{place} has no positions")]
    NoPositions {
        /// The primitive.
        place: PrimitivePlace,
    },
    /// A list of triangles has one or two corners too many.
    #[error("{place} has {count} corners, which is no whole number of triangles")]
    Corners {
        /// The primitive.
        place: PrimitivePlace,
        /// How many corners there are.
        count: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("{place}: corner {corner} names vertex {index}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The primitive.
        place: PrimitivePlace,
        /// Which entry of its index list.
        corner: usize,
        /// The index.
        index: u32,
        /// How many vertices the primitive has.
        vertex_count: usize,
    },
    /// A position or its transform is NaN or infinite.
    #[error("{place}: vertex {vertex} is not finite")]
    NotFinite {
        /// The primitive.
        place: PrimitivePlace,
        /// The vertex, as the primitive counts them.
        vertex: u32,
    },
}
