//! The surfaces that are trimmed, and curves laid on them.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::remesh::Cut;
use selvedge_systems::subdivision::trim::Ground;

use super::{TrimSceneError, disc};
use crate::io::{Cage, Limits, obj};

/// The contoured plate of 0.4 m: a regular lattice of 8 by 8 squares of 50 mm, each cut by its diagonal,
/// with waves of some 6 mm.
///
/// # Errors
/// None, as long as the file that was built in is what it should be.
pub fn plate8() -> Result<Arc<Ground>, TrimSceneError> {
    plate(include_bytes!("../../../data/plates/plate8.obj"), 8)
}

/// The same waves on 1.6 m: 32 by 32 squares of 50 mm.
///
/// # Errors
/// As [`plate8`].
pub fn plate32() -> Result<Arc<Ground>, TrimSceneError> {
    plate(include_bytes!("../../../data/plates/plate32.obj"), 32)
}

fn plate(file: &[u8], squares: u32) -> Result<Arc<Ground>, TrimSceneError> {
    let Cage { positions, triangles, .. } = Cage::from_polygons(obj::read(file, &Limits::default())?)?;
    let mesh = Connectivity::new(positions.len(), &triangles);
    let mesh = Arc::new(mesh.map_err(TrimSceneError::Mesh)?);
    let (n, last) = (squares + 1, (squares + 1) * squares);
    let corners = [0, squares, last, last + n - 1].map(VertexId);
    ready(LoopSurface::plain(mesh, positions, &corners))
}

/// The contoured disc of [`disc::surface`].
///
/// # Errors
/// None, as long as the disc is what it should be.
pub fn contoured_disc() -> Result<Arc<Ground>, TrimSceneError> {
    ready(disc::surface()?)
}

/// A surface, ready to be trimmed.
///
/// # Errors
/// If it cannot be evaluated or searched.
pub fn ready(surface: LoopSurface) -> Result<Arc<Ground>, TrimSceneError> {
    Ok(Arc::new(Ground::new(Arc::new(surface), 0)?))
}

/// A plane curve carried onto `ground` along z: where it leaves the surface, it goes on in the plane.
/// The surface is a graph over the plane, so a vertical line meets it once.
///
/// # Errors
/// None: z is a direction.
pub fn lay(ground: &Ground, plane: Arc<dyn Curve>) -> Result<Arc<dyn Curve>, TrimSceneError> {
    let above: Arc<dyn Curve> = Arc::new(Lifted(Arc::clone(&plane)));
    let onto = ProjectedCurve::new(above, DVec3::NEG_Z, Arc::clone(&ground.index), Pick::First)?;
    Ok(Arc::new(Laid { onto, plane }))
}

/// The cut along a closed plane curve, laid on `ground`, that takes away what is inside.
///
/// # Errors
/// As [`lay`].
pub fn hole(ground: &Ground, plane: Arc<dyn Curve>) -> Result<Cut, TrimSceneError> {
    let heading = if turns_left(&*plane) { Heading::Against } else { Heading::Along };
    Ok(Cut::new(lay(ground, plane)?, heading))
}

/// The cut along a closed plane curve, laid on `ground`, that keeps what is inside.
///
/// # Errors
/// As [`lay`].
pub fn island(ground: &Ground, plane: Arc<dyn Curve>) -> Result<Cut, TrimSceneError> {
    let hole = hole(ground, plane)?;
    let heading = if hole.heading == Heading::Along { Heading::Against } else { Heading::Along };
    Ok(Cut { heading, ..hole })
}

/// Does a closed plane curve run counter-clockwise? By the area of a polygon on it.
fn turns_left(plane: &dyn Curve) -> bool {
    const SIDES: u32 = 256;
    let at = |k: u32| plane.position(f64::from(k % SIDES) / f64::from(SIDES)).truncate();
    let doubled: f64 = (0..SIDES).map(|k| at(k).perp_dot(at(k + 1))).sum();
    doubled > 0.0
}

/// A plane curve one metre up, above all that it is projected on.
#[derive(Debug)]
struct Lifted(Arc<dyn Curve>);

impl Curve for Lifted {
    fn position(&self, u: f64) -> DVec3 {
        self.0.position(u) + DVec3::Z
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.0.derivative(u)
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        self.0.derivative_before(u)
    }

    fn corners(&self) -> &[f64] {
        self.0.corners()
    }

    fn closed(&self) -> bool {
        self.0.closed()
    }
}

/// A plane curve on a surface, and in its plane beyond: the borders of the surfaces here lie in that
/// plane, so it is continuous.
#[derive(Debug)]
struct Laid {
    onto: ProjectedCurve<LimitSurface>,
    plane: Arc<dyn Curve>,
}

impl Curve for Laid {
    fn position(&self, u: f64) -> DVec3 {
        let on = self.onto.position(u);
        if on.is_finite() { on } else { self.plane.position(u) }
    }

    fn derivative(&self, u: f64) -> DVec3 {
        let on = self.onto.derivative(u);
        if on.is_finite() { on } else { self.plane.derivative(u) }
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        let on = self.onto.derivative_before(u);
        if on.is_finite() { on } else { self.plane.derivative_before(u) }
    }

    fn corners(&self) -> &[f64] {
        self.plane.corners()
    }

    fn closed(&self) -> bool {
        self.plane.closed()
    }
}

/// A point of the plane.
pub(super) const fn flat(p: DVec2) -> DVec3 {
    DVec3::new(p.x, p.y, 0.0)
}
