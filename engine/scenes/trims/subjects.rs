//! The scenes: what is cut from what.

use std::sync::Arc;

use glam::DVec2;
use selvedge_components::curve::Curve;
use selvedge_systems::subdivision::remesh::Cut;
use selvedge_systems::subdivision::trim::Ground;

use super::ground::{contoured_disc, hole, island, plate8, plate32};
use super::shapes::{Bent, circle, direction, outline, slot, star};
use super::{Scene, TrimSceneError, disc};

const fn at(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

/// Middle of the bore, in metres.
const BORE: DVec2 = at(0.013, -0.007);
/// Its radius.
const BORE_RADIUS: f64 = 0.06;

/// A bore of 60 mm in the plate of 0.4 m. [Litke et al. 2001, Fig. 14 and 15]
///
/// # Errors
/// None, as long as the files built in are what they should be.
pub fn bore8() -> Result<Scene, TrimSceneError> {
    bore("plate8 bore R60", plate8()?)
}

/// The same bore in the plate of 1.6 m.
///
/// # Errors
/// As [`bore8`].
pub fn bore32() -> Result<Scene, TrimSceneError> {
    bore("plate32 bore R60", plate32()?)
}

fn bore(name: &str, ground: Arc<Ground>) -> Result<Scene, TrimSceneError> {
    let cut = hole(&ground, circle(BORE, BORE_RADIUS)?)?;
    Ok(Scene { name: name.into(), ground, trims: vec![vec![cut]] })
}

/// The hubcap: a contoured disc of 0.4 m with a middle bore, five bolt holes and five swept cut-outs,
/// each with two rounded corners and a sharp one. All eleven curves are one trim.
/// [Litke et al. 2001, Fig. 12 and 13]
///
/// # Errors
/// None, as long as the disc is what it should be.
pub fn hubcap() -> Result<Scene, TrimSceneError> {
    let ground = contoured_disc()?;
    let mut cuts = vec![hole(&ground, circle(DVec2::ZERO, 0.028)?)?];
    for k in 0..5 {
        let turn = 0.25 + 0.2 * f64::from(k);
        cuts.push(hole(&ground, circle(0.06 * direction(turn + 0.06), 0.0095)?)?);
        cuts.push(hole(&ground, cut_out(turn)?)?);
    }
    Ok(Scene { name: "hubcap".into(), ground, trims: vec![cuts] })
}

/// One of the swept cut-outs, about an angle in turns: a rounded triangle whose leading outer corner is
/// sharp.
fn cut_out(turn: f64) -> Result<Arc<dyn Curve>, TrimSceneError> {
    // Along the arc of radius 0.13, and the radius.
    let plane = outline(&[(at(0.058, 0.168), 0.0), (at(-0.058, 0.162), 0.052), (at(0.0, 0.074), 0.052)])?;
    Ok(Arc::new(Bent { plane, reference: 0.13, turn, twist: 0.45 }))
}

/// Walls between the bore and the rim of the disc that [`thin_wall`] is known by, in metres.
pub const WALLS: [f64; 8] = [0.020, 0.010, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001];

/// How far the bore goes through the rim beyond these, in metres, as negative walls.
pub const THROUGH: [f64; 2] = [-0.005, -0.03];

/// A bore of 30 mm in the contoured disc, its edge `wall` metres from the rim; a negative wall means
/// that it cuts through. [Litke et al. 2001, Fig. 16]
///
/// # Errors
/// None, as long as the disc is what it should be.
pub fn thin_wall(wall: f64) -> Result<Scene, TrimSceneError> {
    const BORE: f64 = 0.03;
    let ground = contoured_disc()?;
    let middle = (disc::RADIUS - BORE - wall) * direction(0.07);
    let cut = hole(&ground, circle(middle, BORE)?)?;
    let name = if wall < 0.0 {
        format!("bore {} mm through the rim", -1e3 * wall)
    } else {
        format!("wall of {} mm", 1e3 * wall)
    };
    Ok(Scene { name, ground, trims: vec![vec![cut]] })
}

/// A star with sharp convex and concave corners, an S-shaped slot, and a round hole with an island in
/// it, in the plate of 0.4 m; one scene each.
///
/// # Errors
/// None, as long as the files built in are what they should be.
pub fn stars() -> Result<Vec<Scene>, TrimSceneError> {
    let ground = plate8()?;
    let hole = |plane| hole(&ground, plane);
    let sharp = hole(star(at(0.008, -0.005), 5, [0.045, 0.11], 0.25)?)?;
    let round = hole(circle(at(0.01, -0.01), 0.11)?)?;
    let island = island(&ground, star(at(0.012, -0.006), 4, [0.035, 0.07], 0.12)?)?;
    let scenes = [("star", vec![sharp]), ("S-shaped slot", vec![hole(s_slot()?)?]), ("island", vec![round, island])];
    let scene = |(name, cuts): (&str, Vec<Cut>)| Scene { name: name.into(), ground: ground.clone(), trims: vec![cuts] };
    Ok(scenes.into_iter().map(scene).collect())
}

fn s_slot() -> Result<Arc<dyn Curve>, TrimSceneError> {
    let line = [(-60, 75), (0, 92), (55, 65), (40, 20), (-15, -5), (-50, -35), (-45, -80), (10, -100), (65, -85)];
    Ok(slot(&line.map(|(x, y)| at(1e-3 * f64::from(x), 1e-3 * f64::from(y))), 0.026)?)
}

/// Twenty trims of the plate of 1.6 m, one after the other: a ring of bores, then slots, stars and bores
/// between them, the last ones through edges that earlier ones have left.
///
/// # Errors
/// None, as long as the files built in are what they should be.
pub fn successive() -> Result<Scene, TrimSceneError> {
    let ground = plate32()?;
    let mut trims: Vec<Vec<Cut>> = Vec::new();
    let mut cut = |plane: Arc<dyn Curve>| -> Result<(), TrimSceneError> {
        trims.push(vec![hole(&ground, plane)?]);
        Ok(())
    };
    for k in 0..8 {
        let turn = 0.01 + 0.125 * f64::from(k);
        cut(circle(at(0.02, -0.01) + 0.42 * direction(turn), 0.05 + 0.004 * f64::from(k))?)?;
    }
    for k in 0..4 {
        let middle = at(0.02, -0.01) + 0.17 * direction(0.06 + 0.25 * f64::from(k));
        cut(star(middle, 4 + k, [0.03, 0.07], 0.03 * f64::from(k))?)?;
    }
    for k in 0..4 {
        let out = direction(0.0725 + 0.25 * f64::from(k));
        let line = [0.56, 0.60, 0.64, 0.68].map(|r| r * out + at(0.0, 0.03) * (40.0 * (r - 0.62)));
        cut(slot(&line, 0.04)?)?;
    }
    // Through what is there: bores over the rims of the first four.
    for k in 0..4 {
        let turn = 0.01 + 0.25 * f64::from(k);
        let middle = at(0.02, -0.01) + 0.42 * direction(turn) + (0.055 + 0.004 * f64::from(k)) * direction(turn + 0.5);
        cut(circle(middle, 0.035)?)?;
    }
    Ok(Scene { name: "trims in a row".into(), ground, trims })
}
