//! What a world should be, and a world that is.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge::bevy_ecs::prelude::*;
use selvedge::curve::{Curve, Heading};
use selvedge::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
use selvedge::job::Cancelled;
use selvedge::mesh::VertexId;
use selvedge::subdivision::{ControlPoints, LoopSurface, Position};
use selvedge::tolerance::Tolerance;
use selvedge::triangulation::TriangulateOptions;
use selvedge::trim::{Sides, TrimOptions};
use selvedge::{Engine, Pass, TrimProgress};

use super::Draw;
use super::grounds::Start;
use super::shapes::{Frame, Shape, laid, lies_on, place, round};
use selvedge::evaluate::Evaluate;

/// A curve, and what another may be laid beside.
#[derive(Clone)]
pub struct Line {
    /// `None` once its entity has gone.
    pub curve: Option<Arc<dyn Curve>>,
    pub frame: Frame,
    pub shape: Shape,
    pub size: f64,
}

/// A trim, in the order of the world's.
#[derive(Clone)]
pub struct Cutting {
    pub cuts: Vec<(usize, Heading)>,
    pub tolerance: Tolerance,
    pub options: TrimOptions,
    pub cancelled: bool,
}

/// What a world should be.
#[derive(Clone)]
pub struct Model {
    pub surface: LoopSurface,
    pub lines: Vec<Line>,
    pub trims: Vec<Cutting>,
    pub triangles: Option<TriangulateOptions>,
    pub tolerance: Tolerance,
    pub edge: f64,
}

impl Model {
    pub fn new(start: &Start, draw: &mut Draw) -> Self {
        let edge = start.ground.edge;
        let fit = edge * 10.0_f64.powf(draw.between(-3.5, -2.0));
        let tolerance = Tolerance { fit, chord: fit, curve: fit };
        let surface = LoopSurface::clone(&start.ground.surface);
        Self { surface, lines: Vec::new(), trims: Vec::new(), triangles: None, tolerance, edge }
    }

    /// Adds a line somewhere, or beside one that is there. Returns its index.
    pub fn add_line(&mut self, start: &Start, draw: &mut Draw) -> usize {
        let line = self.new_line(start, draw);
        self.lines.push(line);
        self.lines.len() - 1
    }

    pub fn new_line(&self, start: &Start, draw: &mut Draw) -> Line {
        let ground = &start.ground;
        loop {
            let mut size = ground.edge * 0.3 * 12.0_f64.powf(draw.unit());
            if draw.chance(0.04) {
                size *= 0.01;
            }
            let mut shape = Shape::any(draw);
            let beside =
                (!self.lines.is_empty() && draw.chance(0.5)).then(|| &self.lines[draw.below(self.lines.len())]);
            let frame = match beside {
                // In the same plane: apart, tangent from outside or within, crossing, or one in the other.
                Some(line) => {
                    let turn = DVec2::from_angle(std::f64::consts::TAU * draw.unit());
                    let apart = match draw.below(5) {
                        0 => line.size + size,
                        1 => (line.size - size).abs(),
                        2 => line.size + size * 1.3,
                        3 => line.size * draw.between(0.3, 1.0),
                        _ => {
                            shape = line.shape;
                            size = line.size * draw.between(0.3, 0.8);
                            0.0
                        }
                    };
                    line.frame.moved(turn * apart)
                }
                None => {
                    let at = place(ground, draw);
                    let frame = if start.is_flat() {
                        Frame::flat(ground.limit().position(at))
                    } else {
                        Frame::tangent(ground, at, draw)
                    };
                    // Exactly through the place, or about it.
                    if draw.chance(0.2) { frame.moved(DVec2::new(size, 0.0)) } else { frame }
                }
            };
            let curve = if draw.chance(0.06) {
                let vertex = VertexId::new(draw.below(ground.surface.mesh.vertex_count()));
                round(ground, vertex)
            } else {
                shape.outline(&frame, size, draw).and_then(|plane| laid(ground, &frame, plane))
            };
            // Over the rim of what is flat, a curve may run on; elsewhere it is drawn again, but for a few.
            let anywhere = start.is_flat() || draw.chance(0.02);
            let is_meant = |curve: &dyn Curve| anywhere || lies_on(ground, &frame, curve, self.tolerance.curve);
            if let Some(curve) = curve.filter(|curve| is_meant(&**curve)) {
                return Line { curve: Some(curve), frame, shape, size };
            }
        }
    }

    pub fn add_trim(&mut self, start: &Start, draw: &mut Draw) {
        let heading = |draw: &mut Draw| if draw.chance(0.9) { Heading::Against } else { Heading::Along };
        let mut cuts = Vec::new();
        for _ in 0..[1, 1, 1, 1, 2, 2, 3][draw.below(7)] {
            let known = !self.lines.is_empty() && draw.chance(0.08);
            let line = if known { draw.below(self.lines.len()) } else { self.add_line(start, draw) };
            let within = cuts.len() == 1 && draw.chance(0.5);
            cuts.push((line, if within { Heading::Along } else { heading(draw) }));
        }
        let sides = if draw.chance(0.35) { Sides::Both } else { Sides::Left };
        let options = TrimOptions { sides, ..TrimOptions::default() };
        self.trims.push(Cutting { cuts, tolerance: self.tolerance, options, cancelled: false });
    }
}

/// A world.
pub struct Live {
    pub engine: Engine,
    pub source: Entity,
    pub lines: Vec<Entity>,
    pub trims: Vec<Entity>,
}

impl Live {
    /// A world that is what it should be, from the beginning.
    pub fn of(model: &Model) -> Self {
        let mut engine = Engine::new();
        let source = engine.spawn_surface(&model.surface);
        let mut live = Self { engine, source, lines: Vec::new(), trims: Vec::new() };
        for line in &model.lines {
            live.spawn_line(line);
        }
        for trim in &model.trims {
            live.spawn_trim(trim);
        }
        live
    }

    pub fn spawn_line(&mut self, line: &Line) {
        let entity = match &line.curve {
            Some(curve) => self.engine.spawn_curve(Arc::clone(curve)),
            None => self.engine.world_mut().spawn_empty().id(),
        };
        self.lines.push(entity);
    }

    pub fn spawn_trim(&mut self, trim: &Cutting) {
        let cuts: Vec<_> = trim.cuts.iter().map(|&(line, heading)| (self.lines[line], heading)).collect();
        let entity = self.engine.spawn_trim(self.source, &cuts, Some(trim.tolerance), trim.options.clone());
        if trim.cancelled {
            self.engine.world_mut().entity_mut(entity).insert(Cancelled);
        }
        self.trims.push(entity);
    }

    pub fn point(&self, index: usize) -> Entity {
        self.engine.world().get::<ControlPoints>(self.source).expect("a surface").0[index]
    }

    pub fn move_point(&mut self, index: usize, to: DVec3) {
        let point = self.point(index);
        self.engine.world_mut().get_mut::<Position>(point).expect("a point").0 = to;
    }

    pub fn update(&mut self) {
        self.engine.update();
    }

    /// Passes until nothing is left to do; not forever.
    pub fn settle(&mut self) -> Result<(), String> {
        let ends = (0..20_000).any(|_| self.engine.update() == Pass::Idle);
        if ends { Ok(()) } else { Err("it never comes to rest".into()) }
    }

    /// Does a pass do nothing where there is nothing to do?
    pub fn is_at_rest(&mut self) -> Result<(), String> {
        let written = |live: &Self| {
            let world = live.engine.world();
            let d = world.resource::<SubdivisionDiagnostics>();
            let g = world.resource::<GroundDiagnostics>();
            [
                d.admit,
                d.locate,
                d.remesh,
                d.relax,
                d.correspond,
                d.modify,
                d.refine,
                d.audit,
                d.compose,
                d.advance,
                g.gather,
                g.check,
                g.triangulate,
                g.audit,
            ]
            .map(|c| c.written)
        };
        let before = written(self);
        for _ in 0..2 {
            self.engine.update();
        }
        let after = written(self);
        if before == after { Ok(()) } else { Err(format!("passes with nothing to do: {before:?} {after:?}")) }
    }

    /// How many trims are made, and why others are not.
    pub fn counts(&self) -> (usize, Vec<String>) {
        let (mut made, mut refused) = (0, Vec::new());
        for &trim in &self.trims {
            match self.engine.trim_progress(trim) {
                Some(TrimProgress::Finished(_)) => made += 1,
                Some(TrimProgress::Failed(why)) => refused.push(class(&format!("{:?}", why.why))),
                _ => {}
            }
        }
        (made, refused)
    }
}

/// The variants of an error, from the outermost inwards.
fn class(text: &str) -> String {
    let names = text
        .split(['(', '{', ' ', ',', ':', '[', ')', '}'])
        .filter(|w| w.chars().next().is_some_and(char::is_uppercase));
    let mut names: Vec<&str> = names.take(4).collect();
    names.dedup();
    names.join("/")
}
