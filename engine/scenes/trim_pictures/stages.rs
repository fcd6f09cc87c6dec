//! The stages of remeshing, in the domain, and the points that correspond anew.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::Evaluate;
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::target::Target;
use selvedge_components::trim::TrimFault;
use selvedge_systems::closest::Search;
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::relax::RelaxOptions;
use selvedge_systems::subdivision::remesh::{FaceOrigin, Fate, RemeshOptions, Remeshed, VertexOrigin, remesh};

use super::{TrimPictureError, draw_images, limit_faces, root_faces};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::{Colour, palette};
use crate::diagram::domain::{Domain, Face};
use crate::diagram::grid::{Cell, Grid};
use crate::scenes::trims::{TrimSceneError, Trimmed};

/// Pixels across one diagram.
const SIZE: u32 = 620;
/// A whole face of the given cage.
const GROUND: Colour = Colour::hex(0xf1_f1_ee);
/// A face of a finer level.
const FINE: Colour = Colour::hex(0xcf_dd_ea);
/// A face of the strip along a curve.
const STRIP: Colour = Colour::hex(0xf0_c9_a4);

/// The cage with the pre-image; refined; without what goes; attached to the curve; relaxed. [Fig. 9]
///
/// # Errors
/// As the drawing and remeshing.
pub fn figure(trimmed: &Trimmed) -> Result<Canvas, TrimPictureError> {
    let limit = trimmed.ground.limit();
    let all = root_faces(limit);
    let page = || Domain::new(&all, SIZE);
    let line = Stroke::new(palette::RED, 2.6);
    let cell = |page: Domain, caption: String| Cell::new(page.into_canvas(), caption);

    let mut first = page()?;
    first.fill(&all, GROUND);
    first.edges(&all, palette::SLATE, 1.0);
    draw_images(&mut first, &trimmed.images, &line);

    let mut refined = page()?;
    let finest = draw_leaves(&mut refined, limit, &trimmed.remeshed, |_| true);
    draw_images(&mut refined, &trimmed.images, &line);

    let mut removed = page()?;
    draw_cage(&mut removed, &trimmed.remeshed, |origin| !matches!(origin, FaceOrigin::Strip { .. }));
    draw_images(&mut removed, &trimmed.images, &line);

    let unrelaxed = remesh_without_relaxation(trimmed)?;
    let mut cells = vec![
        cell(first, format!("{} faces and the pre-image", all.len())),
        cell(refined, format!("refined, down to level {finest}")),
        cell(removed, "what stays of it".into()),
    ];
    for (remeshed, words) in [(&unrelaxed, "attached to the curve"), (&*trimmed.remeshed, "relaxed")] {
        let mut page = page()?;
        draw_cage(&mut page, remeshed, |_| true);
        let worst = remeshed.relaxed.iter().map(|r| r.worst_shape[1]).fold(f64::INFINITY, f64::min);
        cells.push(cell(page, format!("{words}: worst shape in the strip {worst:.2}")));
    }
    Ok(Grid::new(5, 20.0).lettered().compose(&cells)?)
}

/// The same cage with the strip as it is first laid.
fn remesh_without_relaxation(trimmed: &Trimmed) -> Result<Remeshed, TrimPictureError> {
    let still = RelaxOptions { sweeps: 0, ..RelaxOptions::default() };
    let options = RemeshOptions { relax: still, ..RemeshOptions::default() };
    Ok(remesh(Arc::clone(&trimmed.ground.surface), &trimmed.cuts, &trimmed.images, &options)
        .map_err(|why| TrimSceneError::from(TrimFault::Remesh(why)))?)
}

/// The new cages of several trims, each as far as it lies within `around` metres of its first curve's box;
/// what the curves join is coloured. [Fig. 16]
///
/// # Errors
/// As the drawing.
pub fn cages(trims: &[&Trimmed], around: f64) -> Result<Canvas, TrimPictureError> {
    let near = |trimmed: &&Trimmed| -> Vec<Face> {
        let mut all = faces(&trimmed.remeshed);
        let curve: Vec<DVec3> =
            trimmed.images.first().into_iter().flat_map(|i| &i.points).map(|p| p.position).collect();
        let low = curve.iter().fold(DVec3::INFINITY, |l, &p| l.min(p)) - DVec3::splat(around);
        let high = curve.iter().fold(DVec3::NEG_INFINITY, |h, &p| h.max(p)) + DVec3::splat(around);
        let inside = |face: &Face| face.iter().all(|p| p.cmpge(low).all() && p.cmple(high).all());
        if all.iter().any(inside) {
            all.retain(inside);
        }
        all
    };
    // All on one scale, so that what moves is seen to move.
    let shown: Vec<Face> = trims.iter().flat_map(near).collect();
    let cell = |trimmed: &&Trimmed| -> Result<Cell, TrimPictureError> {
        let all = faces(&trimmed.remeshed);
        let mut page = Domain::about(&all, &shown, if trims.len() == 1 { 2 * SIZE } else { SIZE })?;
        draw_cage(&mut page, &trimmed.remeshed, |_| true);
        Ok(Cell::new(page.into_canvas(), format!("{}: {} faces", trimmed.name, all.len())))
    };
    let cells = trims.iter().map(cell).collect::<Result<Vec<_>, _>>()?;
    Ok(Grid::new(trims.len().min(5), 20.0).compose(&cells)?)
}

/// Draws the leaves whose fate is wanted; returns their finest level.
fn draw_leaves(page: &mut Domain, limit: &LimitSurface, remeshed: &Remeshed, wanted: impl Fn(Fate) -> bool) -> u32 {
    let finest = remeshed.fates.iter().map(|f| f.0).max().unwrap_or(0);
    for level in 0..=finest {
        let own = remeshed.fates.iter().filter(|&&(l, _, fate)| l == level && wanted(fate));
        let faces = limit_faces(limit, level, own.map(|f| f.1));
        page.fill(&faces, if level == 0 { GROUND } else { FINE });
        page.edges(&faces, palette::SLATE, 1.0);
    }
    finest
}

/// Draws the faces of the new cage of which `wanted` says so, by where they came from.
fn draw_cage(page: &mut Domain, remeshed: &Remeshed, wanted: impl Fn(FaceOrigin) -> bool) {
    let colour = |origin: FaceOrigin| match origin {
        FaceOrigin::Leaf { level: 0, .. } => GROUND,
        FaceOrigin::Strip { .. } => STRIP,
        _ => FINE,
    };
    let faces: Vec<(Face, FaceOrigin)> =
        faces(remeshed).into_iter().zip(remeshed.face_origin.iter().copied()).filter(|f| wanted(f.1)).collect();
    for (face, origin) in &faces {
        page.fill(&[*face], colour(*origin));
    }
    let all: Vec<Face> = faces.into_iter().map(|f| f.0).collect();
    page.edges(&all, palette::SLATE, 1.0);
}

fn faces(remeshed: &Remeshed) -> Vec<Face> {
    remeshed.surface.mesh.faces().iter().map(|f| f.map(|v| remeshed.limit[v.index()])).collect()
}

/// The given cage with the places that correspond anew, and the new cage with the vertices that have
/// them: those whose limit point is no longer the given surface's at their natural place. [Fig. 10]
///
/// # Errors
/// As the drawing.
pub fn resampled(trimmed: &Trimmed) -> Result<Canvas, TrimPictureError> {
    /// Places nearer than this part of an edge to the natural one are not shown as new.
    const SAME: f64 = 1e-3;
    let remeshed = &trimmed.remeshed;
    let limit = trimmed.ground.limit();
    let target = trimmed.ground.target(Search::AroundHint);
    let (mut natural, mut improved) = (Vec::new(), Vec::new());
    let (mut kept, mut moved) = (Vec::new(), Vec::new());
    for (v, x) in limit_points(&remeshed.surface)?.into_iter().enumerate() {
        let on_curve = matches!(remeshed.vertex_origin[v], VertexOrigin::OnCurve { .. });
        if on_curve || remeshed.changed.binary_search(&VertexId::new(v)).is_err() {
            continue;
        }
        let place = limit.position(remeshed.natural[v]);
        let Ok(foot) = target.closest(x, Some(remeshed.natural[v])) else { continue };
        let anew = foot.position.distance(place) > SAME * trimmed.ground.edge;
        (if anew { &mut improved } else { &mut natural }).push(if anew { foot.position } else { place });
        (if anew { &mut moved } else { &mut kept }).push(remeshed.limit[v]);
    }
    let all = root_faces(limit);
    let mut left = Domain::new(&all, SIZE)?;
    left.fill(&all, GROUND);
    left.edges(&all, palette::SLATE, 1.0);
    draw_images(&mut left, &trimmed.images, &Stroke::new(palette::SLATE, 1.4));
    let mut right = Domain::new(&all, SIZE)?;
    draw_cage(&mut right, remeshed, |_| true);
    for (page, small, large) in [(&mut left, &natural, &improved), (&mut right, &kept, &moved)] {
        page.dots(small, 2.2, palette::SLATE);
        page.dots(large, 4.0, palette::RED);
    }
    let cells = [
        Cell::new(left.into_canvas(), format!("{} places found anew on the given cage (red)", improved.len())),
        Cell::new(right.into_canvas(), "the vertices of the new cage that they stand for"),
    ];
    Ok(Grid::new(2, 20.0).lettered().compose(&cells)?)
}

/// The limit point of each vertex.
fn limit_points(surface: &LoopSurface) -> Result<Vec<DVec3>, TrimPictureError> {
    let limit = LimitSurface::new(surface.clone().into()).map_err(TrimSceneError::from)?;
    let mut points = vec![DVec3::NAN; surface.mesh.vertex_count()];
    let roots = (0..surface.mesh.face_count()).map(|f| FaceCode::root(FaceId::new(f)));
    for (corners, face) in surface.mesh.faces().iter().zip(limit_faces(&limit, 0, roots)) {
        corners.iter().zip(face).for_each(|(v, x)| points[v.index()] = x);
    }
    Ok(points)
}
