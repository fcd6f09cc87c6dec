//! Cages by path.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::limits::{self, Limits, TooLarge};
use super::polygons::Polygons;
use super::tags::{TagError, Tags};
use super::{Cage, CageError, obj};

/// Why a file gives no cage.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{}: {why}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        why: io::Error,
    },
    /// The file is longer than it may be.
    #[error("{}: {why}", .path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// How long it is.
        #[source]
        why: TooLarge,
    },
    /// The name of the file ends in nothing that is read here.
    #[error("{}: neither .obj nor .glb", .path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The OBJ file is wrong.
    #[error("{}: {why}", .path.display())]
    Obj {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        why: obj::ObjError,
    },
    /// The GLB file is wrong.
    #[cfg(feature = "gltf")]
    #[error("{}: {why}", .path.display())]
    Glb {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        why: super::glb::GlbError,
    },
    /// The tag file is wrong.
    #[error("{}: {why}", .path.display())]
    Tags {
        /// The tag file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        why: TagError,
    },
    /// What the file holds is no cage.
    #[error("{}: {why}", .path.display())]
    Cage {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        why: CageError,
    },
}

/// Reads a cage from an OBJ or GLB file, by the end of its name. Where a tag file stands beside it
/// (`cage.tags.json` beside `cage.obj`), its tags replace those in the file itself.
///
/// # Errors
/// [`ReadError`], which names the file and the place in it.
pub fn read_cage(path: &Path, limits: &Limits) -> Result<Cage, ReadError> {
    let mut polygons = read_polygons(path, limits)?;
    let tags = path.with_extension("tags.json");
    if tags.is_file() {
        let bytes = read_file(&tags, limits)?;
        polygons.tags = Tags::from_json(&bytes).map_err(|why| ReadError::Tags { path: tags, why })?;
    }
    Cage::from_polygons(polygons).map_err(|why| ReadError::Cage { path: path.to_owned(), why })
}

fn read_polygons(path: &Path, limits: &Limits) -> Result<Polygons, ReadError> {
    let extension = path.extension().map(|end| end.to_ascii_lowercase());
    match extension.as_ref().and_then(|end| end.to_str()) {
        Some("obj") => {
            let bytes = read_file(path, limits)?;
            obj::read(&bytes, limits).map_err(|why| ReadError::Obj { path: path.to_owned(), why })
        }
        #[cfg(feature = "gltf")]
        Some("glb") => {
            let bytes = read_file(path, limits)?;
            super::glb::read(&bytes, limits, super::glb::Weld::default())
                .map_err(|why| ReadError::Glb { path: path.to_owned(), why })
        }
        _ => Err(ReadError::Format { path: path.to_owned() }),
    }
}

/// The bytes of a file that is not too long: judged by its length where the system knows it, and by
/// what comes out of it where it does not.
fn read_file(path: &Path, limits: &Limits) -> Result<Vec<u8>, ReadError> {
    let io = |why| ReadError::Io { path: path.to_owned(), why };
    let refuse = |length: u64| {
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let checked = limits::check("bytes", length, limits.bytes);
        checked.map_err(|why| ReadError::TooLarge { path: path.to_owned(), why })
    };
    let file = File::open(path).map_err(io)?;
    let length = file.metadata().map_err(io)?.len();
    refuse(length)?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    file.take(limits.bytes as u64 + 1).read_to_end(&mut bytes).map_err(io)?;
    refuse(bytes.len() as u64)?;
    Ok(bytes)
}
