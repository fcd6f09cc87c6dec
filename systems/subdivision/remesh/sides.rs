//! The sides of the new surface: those of the source that are left, and those along the cuts.
//!
//! A plain side some of whose edges are split, or that a curve cuts, is no uniform B-spline of its
//! new control points. It becomes a given one: the curve is the border that it had, so its shape
//! stays, and the boundary details make the effective points what they were. A straight one may
//! stay plain: any control points on a line have that line.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, Heading, ParameterError, wrap};
use selvedge_components::mesh::{Connectivity, EdgeId, VertexId};
use selvedge_components::subdivision::{Address, Border, Ends, Side};
use selvedge_components::trim::BorderLine;

use super::Work;
use super::assemble::{Parts, SideOrigin, Vertex};
use super::attach::KnotKind;
use super::borders::{Borders, PlainBorder, given_parameter, is_straight};
use super::error::RemeshError;
use super::remove::{Place as CurvePlace, Trouble};
use super::strip_parameters::{index_of, parameters, unsound};

/// The sides, and what follows from them.
#[derive(Debug, Default)]
pub(super) struct Sides {
    /// Those of the source first, in its order.
    pub sides: Vec<Side>,
    /// By side.
    pub origins: Vec<SideOrigin>,
    /// Boundary details of level 0 on plain sides that are given now.
    pub details: Vec<(VertexId, DVec3)>,
    /// Vertices whose boundary sample or detail is another.
    pub touched: Vec<VertexId>,
}

impl Sides {
    /// Does one of the given sides so far end at `v`? It gives the sample there, and the detail with it.
    fn ends_at(&self, v: VertexId) -> bool {
        let is_given = |side: &&Side| side.ends == Ends::Corners && matches!(side.border, Border::Given { .. });
        self.sides
            .iter()
            .filter(is_given)
            .any(|side| side.vertices.first() == Some(&v) || side.vertices.last() == Some(&v))
    }
}

/// What a border edge belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Owner {
    /// A side of the source.
    Source(u32),
    /// A strip.
    Strip(u32),
}

/// A stretch of border between two corners, or all of a loop.
struct Run {
    owner: Owner,
    vertices: Vec<VertexId>,
    ends: Ends,
}

/// Finds the sides of `mesh`.
///
/// # Errors
/// The places at which a curve ends on a border but the rest begins beyond a corner of it.
pub(super) fn sides(work: &Work<'_>, parts: &Parts, mesh: &Connectivity) -> Result<Sides, Trouble> {
    let borders = Borders::new(work.surface);
    let mut runs = Vec::new();
    for border in mesh.border_loops() {
        check_ends(work, parts, &borders, &border)?;
        split(work, parts, &borders, &border, &mut runs);
    }
    // The older first: where two sides meet, the first gives the bits.
    let line = |run: &Run| match run.owner {
        Owner::Source(s) => BorderLine::Side(s as usize),
        Owner::Strip(s) => BorderLine::Cut(work.curve_of(s, first_knot(parts, run)) as usize),
    };
    runs.sort_by_key(|run| (line(run), run.vertices[0]));
    let mut out = Sides::default();
    for run in runs {
        let line = line(&run);
        match run.owner {
            Owner::Strip(s) => cut_side(work, parts, s, run, line, &mut out),
            Owner::Source(s) => source_side(work, parts, &borders, s as usize, run, &mut out)?,
        }
    }
    Ok(out)
}

/// Between the end of a curve and the next border vertex that is left there is no corner, and they
/// follow each other as the side goes.
fn check_ends(work: &Work<'_>, parts: &Parts, borders: &Borders<'_>, border: &[VertexId]) -> Result<(), Trouble> {
    let next = border.iter().cycle().skip(1);
    for (&a, &b) in border.iter().zip(next) {
        let (strip, knot, l, leaving) = match (parts.vertices[a.index()], parts.vertices[b.index()]) {
            (Vertex::Knot(s, k), Vertex::Lattice(l)) => (s, k, l, false),
            (Vertex::Lattice(l), Vertex::Knot(s, k)) => (s, k, l, true),
            _ => continue,
        };
        let strip = &work.strips[strip as usize];
        let near = work.plan.track.place_of_parameter(strip.cut, strip.knots[knot as usize].t);
        let end = borders.place(work.plan.track.source(near));
        let vertex = &work.adapted.vertices[l as usize];
        let own = borders.edge(vertex.address, leaving).and_then(|e| {
            let (side, step) = borders.of_edge[e.index()]?;
            let within = match vertex.address {
                Address::Edge(e, steps) => borders.within(e, steps, vertex.birth),
                _ => f64::from(u8::from(!leaving)),
            };
            Some((side, f64::from(step) + within))
        });
        let follows = match (end, own) {
            (Some((s, x)), Some((t, y))) if s == t => {
                let round = work.surface.sides[s as usize].edge_count() as f64;
                let apart = if leaving { x - y } else { y - x };
                let closed = work.surface.sides[s as usize].ends == Ends::Closed;
                let apart = if closed { apart.rem_euclid(round) } else { apart };
                // Beyond half a closed side it lies before, not after.
                apart > 0.0 && (!closed || apart < 0.5 * round)
            }
            _ => false,
        };
        if !follows {
            let size = parts.limit[a.index()].distance(parts.limit[b.index()]);
            let places = vec![CurvePlace { near, level: vertex.level, size }];
            return Err(Trouble::TooCoarse {
                what: "too coarse between a curve's end and a corner of the border",
                places,
            });
        }
    }
    Ok(())
}

/// Cuts one border loop into runs.
fn split(work: &Work<'_>, parts: &Parts, borders: &Borders<'_>, border: &[VertexId], runs: &mut Vec<Run>) {
    let n = border.len();
    let owner = |i: usize| {
        let (a, b) = (parts.vertices[border[i].index()], parts.vertices[border[(i + 1) % n].index()]);
        let of = |l: u32, leaving| {
            let edge = borders.edge(work.adapted.vertices[l as usize].address, leaving);
            Owner::Source(edge.and_then(|e| borders.of_edge[e.index()]).map_or(0, |p| p.0))
        };
        match (a, b) {
            (Vertex::Knot(s, _), Vertex::Knot(..)) => Owner::Strip(s),
            (Vertex::Lattice(l), _) => of(l, true),
            (Vertex::Knot(..), Vertex::Lattice(l)) => of(l, false),
        }
    };
    let is_corner = |i: usize| match parts.vertices[border[i].index()] {
        Vertex::Knot(s, k) => work.strips[s as usize].knots[k as usize].kind != KnotKind::Smooth,
        Vertex::Lattice(l) => match work.adapted.vertices[l as usize].address {
            Address::Corner(v) => work.surface.sides.iter().any(|s| s.ends == Ends::Corners && s.vertices[0] == v),
            _ => false,
        },
    };
    let begins: Vec<usize> = (0..n).filter(|&i| is_corner(i) || owner(i) != owner((i + n - 1) % n)).collect();
    if begins.is_empty() {
        // A closed side keeps the vertex that it began with.
        let first = match owner(0) {
            Owner::Source(s) => {
                let wanted = Address::Corner(work.surface.sides[s as usize].vertices[0]);
                let is_first = |v: &VertexId| matches!(parts.vertices[v.index()], Vertex::Lattice(l) if work.adapted.vertices[l as usize].address == wanted);
                border.iter().position(is_first).unwrap_or(0)
            }
            Owner::Strip(_) => 0,
        };
        let vertices = (0..n).map(|i| border[(first + i) % n]).collect();
        runs.push(Run { owner: owner(0), vertices, ends: Ends::Closed });
        return;
    }
    for (k, &from) in begins.iter().enumerate() {
        let to = begins.get(k + 1).map_or(begins[0] + n, |&to| to);
        let vertices = (from..=to).map(|i| border[i % n]).collect();
        runs.push(Run { owner: owner(from), vertices, ends: Ends::Corners });
    }
}

/// The knot that a run along a strip begins with.
fn first_knot(parts: &Parts, run: &Run) -> u32 {
    match parts.vertices[run.vertices[0].index()] {
        Vertex::Knot(_, k) => k,
        Vertex::Lattice(_) => 0,
    }
}

/// A side along a cut. All sides of one stretch of it share its parameters.
fn cut_side(work: &Work<'_>, parts: &Parts, s: u32, run: Run, line: BorderLine, out: &mut Sides) {
    let own = &work.parameters[s as usize];
    let k = first_knot(parts, &run) as usize;
    let heading = work.cuts[work.curve_of(s, k as u32) as usize].heading;
    let curve = Arc::clone(&own.spans[own.spots[k].span as usize]);
    let side = Side {
        vertices: run.vertices,
        ends: run.ends,
        border: Border::Given { curve, first: own.indices[k], heading },
    };
    let last = side.edge_count() as u64;
    out.origins.push(SideOrigin { line, range: [0, last].map(|step| given_at(&side, step)) });
    out.sides.push(side);
}

/// The parameter of a given side after so many steps; 0 on a plain one.
fn given_at(side: &Side, step: u64) -> f64 {
    match (&side.border, side.curve_index(0, step)) {
        (Border::Given { curve, .. }, Some(index)) => curve.parameter(0, index),
        _ => 0.0,
    }
}

/// The point of a given side after so many steps of a level.
fn sample_at(side: &Side, level: u32, step: u64) -> Option<DVec3> {
    let Border::Given { curve, .. } = &side.border else { return None };
    Some(curve.sample(level, side.curve_index(level, step)?))
}

/// A place on a side of the source.
#[derive(Clone, Copy)]
struct Place {
    /// In root edges from the side's first vertex.
    x: f64,
    /// The level whose control point the vertex has; `None` where a curve ends on the side.
    level: Option<u32>,
    /// The parameter of the junction where a curve ends on the side.
    end: Option<f64>,
}

/// What is left of a side of the source.
fn source_side(
    work: &Work<'_>,
    parts: &Parts,
    borders: &Borders<'_>,
    s: usize,
    run: Run,
    out: &mut Sides,
) -> Result<(), Trouble> {
    let side = &work.surface.sides[s];
    let whole = side.edge_count() as f64;
    let line = BorderLine::Side(s);
    let mut places: Vec<Place> = Vec::with_capacity(run.vertices.len());
    for (i, v) in run.vertices.iter().enumerate() {
        let mut place = place_of(work, parts, borders, *v, i + 1 == run.vertices.len());
        // Round a closed side, or to the far end of an open one.
        while places.last().is_some_and(|last| place.x <= last.x) && place.x <= 2.0 * whole {
            place.x += whole;
        }
        places.push(place);
    }
    let untouched = run.ends == side.ends
        && run.vertices.len() == side.vertices.len()
        && places.iter().enumerate().all(|(i, p)| p.x == i as f64 && p.level == Some(0));
    let range = [0, run.vertices.len() - 1].map(|i| if run.ends == Ends::Closed { 0.0 } else { places[i].x / whole });
    if untouched {
        out.origins.push(SideOrigin { line, range: range_of(side, range) });
        out.sides.push(Side { vertices: run.vertices, ..side.clone() });
        return Ok(());
    }
    // A side that is refined as a whole is the same spline.
    let base = work.options.adapt.base;
    let step = 1.0 / f64::from(1_u32 << base);
    let uniform = run.ends == side.ends
        && places.iter().enumerate().all(|(i, p)| p.x == i as f64 * step && p.level == Some(base));
    // Next to the end of a curve a finer cage may help.
    let knot = run.vertices.iter().find_map(|v| match parts.vertices[v.index()] {
        Vertex::Knot(strip, k) => Some((strip, k as usize)),
        Vertex::Lattice(_) => None,
    });
    let trouble = |Unsound { u, at, source }| match knot {
        Some((strip, k)) => unsound(work, strip, k),
        None => Trouble::Error(RemeshError::Parameters { side: s, u, at, source }),
    };
    let border = match &side.border {
        Border::Plain if uniform || is_straight(work.surface, side) => Border::Plain,
        Border::Plain => {
            let curve: Arc<dyn Curve> = Arc::new(PlainBorder::new(work.surface, side));
            let u = places.iter().map(|p| p.end.unwrap_or(p.x / whole)).collect();
            given(&curve, u, Heading::Along, run.ends).map_err(trouble)?
        }
        Border::Given { curve, heading, .. } => {
            let u = places.iter().map(|p| p.end.unwrap_or_else(|| given_parameter(side, curve, p.x, p.level)));
            given(curve.curve(), u.collect(), *heading, run.ends).map_err(trouble)?
        }
    };
    let side_now = Side { vertices: run.vertices, ends: run.ends, border };
    for (i, place) in places.iter().enumerate() {
        let v = side_now.vertices[i];
        let (Vertex::Lattice(l), Some(sample)) = (parts.vertices[v.index()], sample_at(&side_now, 0, i as u64)) else {
            continue;
        };
        // Where the border's samples moved along it, the effective points stay what they were.
        let before = place.level.and_then(|level| {
            let steps = (place.x * (1_u64 << level) as f64).round() as u64;
            sample_at(side, level, steps)
        });
        if before != Some(sample) && !out.ends_at(v) {
            out.touched.push(v);
            out.details.push((v, sample - work.adapted.vertices[l as usize].point));
        }
    }
    let range = if matches!(side.border, Border::Plain) { range } else { range_of(&side_now, range) };
    out.origins.push(SideOrigin { line, range });
    out.sides.push(side_now);
    Ok(())
}

/// The parameters of a given side's ends; of a plain one, what is given.
fn range_of(side: &Side, plain: [f64; 2]) -> [f64; 2] {
    match side.border {
        Border::Plain => plain,
        Border::Given { .. } => [0, side.edge_count() as u64].map(|step| given_at(side, step)),
    }
}

fn place_of(work: &Work<'_>, parts: &Parts, borders: &Borders<'_>, v: VertexId, last: bool) -> Place {
    match parts.vertices[v.index()] {
        Vertex::Lattice(l) => {
            let vertex = &work.adapted.vertices[l as usize];
            let level = Some(vertex.level);
            let step = |e: EdgeId| borders.of_edge[e.index()].map_or(0.0, |p| f64::from(p.1));
            let x = match vertex.address {
                Address::Edge(e, steps) => step(e) + borders.within(e, steps, vertex.birth),
                // Of the two edges at a vertex, the one of this side.
                address => borders.edge(address, !last).map_or(0.0, |e| step(e) + f64::from(u8::from(last))),
            };
            Place { x, level, end: None }
        }
        Vertex::Knot(s, k) => {
            let strip = &work.strips[s as usize];
            let near = work.plan.track.place_of_parameter(strip.cut, strip.knots[k as usize].t);
            let x = borders.place(work.plan.track.source(near)).map_or(0.0, |p| p.1);
            let junction = work.parameters[s as usize].spots[k as usize].junction;
            let end = junction.map(|j| work.plan.junctions[j as usize].ends[0].1);
            Place { x, level: None, end }
        }
    }
}

/// Parameters along a side of the source that make no sound list, and where.
struct Unsound {
    u: f64,
    at: DVec3,
    source: ParameterError,
}

/// A given border through these parameters, in the order of the side's vertices.
fn given(curve: &Arc<dyn Curve>, mut u: Vec<f64>, heading: Heading, ends: Ends) -> Result<Border, Unsound> {
    if heading == Heading::Against {
        u.reverse();
    }
    let count = u.len();
    let mut first = if heading == Heading::Along { 0 } else { count - 1 };
    if ends == Ends::Closed {
        u.iter_mut().for_each(|u| *u = wrap(*u));
        let smallest = (0..count).min_by(|&a, &b| u[a].total_cmp(&u[b])).unwrap_or(0);
        u.rotate_left(smallest);
        first = (first + count - smallest) % count;
    }
    let made = parameters(curve, u.clone(), ends == Ends::Closed, &[]);
    let curve = made.map_err(|source| {
        let u = u.get(index_of(&source, &u)).copied().unwrap_or(0.0);
        Unsound { u, at: curve.position(u), source }
    })?;
    Ok(Border::Given { curve, first: first as u64, heading })
}
