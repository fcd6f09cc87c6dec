//! OBJ out.

use std::io::{self, Write};

use selvedge_components::mesh::VertexId;
use selvedge_components::triangles::Triangles;

use crate::io::cage::Cage;
use crate::io::check::{WriteError, check};
use crate::io::tags::INFINITELY_SHARP;

/// Writes triangles: positions, colours behind them when there are any, and normals when there are
/// any. Every number reads back as the same bits.
///
/// # Errors
/// [`WriteError`] when the triangles are not what [`Triangles`] promises, or `out` fails.
pub fn write(out: &mut impl Write, surface: &Triangles) -> Result<(), WriteError> {
    check(surface)?;
    write_checked(out, surface)?;
    Ok(())
}

/// Writes a cage, with its corners as tags.
///
/// # Errors
/// As [`write`](fn@write).
pub fn write_cage(out: &mut impl Write, cage: &Cage) -> Result<(), WriteError> {
    write(out, &cage.to_triangles())?;
    write_corners(out, &cage.corners)?;
    Ok(())
}

// `{:?}` prints the shortest decimals that read back as the same double, and switches to an exponent
// where `{}` would print hundreds of digits.
fn write_checked(out: &mut impl Write, surface: &Triangles) -> io::Result<()> {
    for (v, p) in surface.positions.iter().enumerate() {
        write!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
        if let Some([r, g, b]) = surface.colours.get(v) {
            write!(out, " {r:?} {g:?} {b:?}")?;
        }
        writeln!(out)?;
    }
    for n in &surface.normals {
        writeln!(out, "vn {:?} {:?} {:?}", n.x, n.y, n.z)?;
    }
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        if surface.normals.is_empty() {
            writeln!(out, "f {a} {b} {c}")?;
        } else {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
    }
    Ok(())
}

fn write_corners(out: &mut impl Write, corners: &[VertexId]) -> io::Result<()> {
    if corners.is_empty() {
        return Ok(());
    }
    write!(out, "t corner {}/1/0", corners.len())?;
    for corner in corners {
        write!(out, " {corner}")?;
    }
    writeln!(out, " {INFINITELY_SHARP:?}")
}
