//! You will see what reading a broken file comes to: for every file of `data/refuse`, or of the folders
//! that are named, and for files spoiled here, the type of the error, what it says, and how long it took
//! to say so. `--json` prints one array.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;
#[path = "../tests/support/glb.rs"]
mod by_hand;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use selvedge::io::{CageError, Limits, ReadError, read_cage};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, folders): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let mut rows = Vec::new();
    let shipped = || vec![concat!(env!("CARGO_MANIFEST_DIR"), "/data/refuse").to_owned()];
    for folder in if folders.is_empty() { shipped() } else { folders } {
        for path in cages(Path::new(&folder))? {
            rows.push(attempt(&path));
        }
    }
    let folder = std::env::temp_dir().join(format!("selvedge-refuse-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let made = spoil(&folder);
    fs::remove_dir_all(&folder)?;
    rows.extend(made?);

    if flags.iter().any(|flag| flag == "--json") {
        say!("{}", Value::from(rows.clone()));
    } else {
        for row in &rows {
            say!(
                "{:24} {:8.3} ms  {}",
                row["file"].as_str().unwrap_or(""),
                row["ms"].as_f64().unwrap_or(0.0),
                row["type"]
            );
            say!("    {}", row["error"].as_str().unwrap_or(""));
        }
    }
    let taken = rows.iter().filter(|row| row["type"].is_null()).count();
    if taken == 0 { Ok(()) } else { Err(format!("{taken} files were not refused").into()) }
}

/// The OBJ and GLB files of a folder, by name.
fn cages(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let paths: Vec<PathBuf> = fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect())
        .map_err(|why| format!("{}: {why}", folder.display()))?;
    let is_cage = |path: &PathBuf| path.extension().is_some_and(|end| end == "obj" || end == "glb");
    let mut paths: Vec<PathBuf> = paths.into_iter().filter(is_cage).collect();
    paths.sort();
    Ok(paths)
}

/// Reads a file as any user would, and says what came of it; a `type` of null where it was taken.
fn attempt(path: &Path) -> Value {
    let start = Instant::now();
    let outcome = read_cage(path, &Limits::default());
    let ms = start.elapsed().as_secs_f64() * 1e3;
    let (kind, error) = match &outcome {
        Ok(_) => (None, String::new()),
        Err(why) => (Some(kind(why)), why.to_string()),
    };
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let bytes = path.metadata().map_or(0, |file| file.len());
    // The folder is the user's to know; the place within the file is what counts.
    let error = error.replace(&path.display().to_string(), &file);
    json!({ "file": file, "bytes": bytes, "type": kind, "error": error, "ms": ms })
}

/// The variants of the error, from the outermost to that which says what is wrong.
fn kind(why: &ReadError) -> String {
    let inner = match why {
        ReadError::Obj { why, .. } => format!("{why:?}"),
        ReadError::Glb { why, .. } => format!("{why:?}"),
        ReadError::Tags { why, .. } => format!("{why:?}"),
        ReadError::Cage { why: CageError::Faulty { faults }, .. } => {
            faults.first().map_or_else(String::new, |first| format!("{:?}", first.fault))
        }
        _ => String::new(),
    };
    [format!("{why:?}"), inner]
        .iter()
        .map(|text| variant(text))
        .filter(|name| !name.is_empty())
        .collect::<Vec<_>>()
        .join("::")
}

/// The name that the `Debug` form of a value begins with.
fn variant(text: &str) -> &str {
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("")
}

/// Writes files that are broken in every way that a download, a disk or malice breaks them, and tries each.
fn spoil(folder: &Path) -> Result<Vec<Value>, Box<dyn Error>> {
    const TRIANGLE: &str = "v 0 0 0\nv 0 1 0\nv 1 0 0\n";
    let whole = fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/data/cages/loop_cube.obj"))?;
    let last_corner = whole.iter().rposition(|&byte| byte == b' ').ok_or("the cube has faces")?;
    let mut rows = Vec::new();
    let mut attempt_bytes = |name: &str, bytes: &[u8]| -> Result<(), Box<dyn Error>> {
        fs::write(folder.join(name), bytes)?;
        rows.push(attempt(&folder.join(name)));
        Ok(())
    };
    attempt_bytes("empty.obj", b"")?;
    attempt_bytes("truncated.obj", &whole[..last_corner])?;
    attempt_bytes("nan.obj", format!("{TRIANGLE}v 1 nan 0\nf 1 2 3\n").as_bytes())?;
    attempt_bytes("huge_index.obj", format!("{TRIANGLE}f 1 2 4294967295\n").as_bytes())?;
    attempt_bytes("many_sides.obj", [TRIANGLE.as_bytes(), b"f", &b" 1".repeat(16 << 20)].concat().as_slice())?;
    attempt_bytes("zeros.obj", &vec![0; 64 << 20])?;

    let (scene, buffer) = by_hand::tetrahedron();
    let glb = by_hand::container(&scene, &buffer);
    let mut not_finite = buffer.clone();
    not_finite[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut far = buffer.clone();
    far[48..52].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut claims = scene.clone();
    claims["accessors"][0]["count"] = json!((1_u64 << 30) / 12);
    let mut header = glb.clone();
    header[8..12].copy_from_slice(&(1_u32 << 30).to_le_bytes());
    attempt_bytes("empty.glb", b"")?;
    attempt_bytes("truncated.glb", &glb[..glb.len() / 2])?;
    attempt_bytes("nan.glb", &by_hand::container(&scene, &not_finite))?;
    attempt_bytes("huge_index.glb", &by_hand::container(&scene, &far))?;
    attempt_bytes("claims_a_gigabyte.glb", &by_hand::container(&claims, &buffer))?;
    attempt_bytes("header_of_a_gigabyte.glb", &header)?;

    // Sparse: the disk holds nothing of it.
    for name in ["gigabyte.obj", "gigabyte.glb"] {
        fs::File::create(folder.join(name))?.set_len(1 << 30)?;
        rows.push(attempt(&folder.join(name)));
    }
    Ok(rows)
}
