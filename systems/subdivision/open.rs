//! Open: a level made ready to be fitted and measured, step by step
//!
//! A level in work holds two more, one to fit at and one to measure at, so it is the largest piece of
//! work that a fit begins; it is made in steps of some milliseconds.

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::subdivision::{
    Address, CornerTable, Details, FaceCode, Kind, LevelMesh, LimitRows, LoopSurface, Quartered, RingState, Rows,
    SideEnd, Step,
};

use super::chain::{self, Level, Way};
use super::fit::{Region, zone};
use super::modify::Solve;
use super::{region, rules};

/// The level in work.
#[derive(Debug, Default)]
pub(super) struct OpenLevel {
    pub level: u32,
    /// Levels `j`, `j + 1` and `j + 2`.
    pub levels: [Level; 3],
    pub steps: [Step; 2],
    /// Limit rows at `j + 1`: what is fitted.
    pub fit_rows: LimitRows,
    /// The vertices of `j + 2` that are measured, ascending. Their limit rows are made where they are used,
    /// once or twice: kept, they would be the largest part of a level.
    pub tested: Vec<u32>,
    /// The patches of level `j` that the movable vertices influence, ascending.
    pub influenced: Vec<FaceCode>,
    /// Vertices of level `j` that may move, ascending, and their addresses.
    pub movable: Vec<u32>,
    pub addresses: Vec<Address>,
    pub active: Vec<(u32, Address)>,
    /// What has been added to each movable vertex, as a move of its effective point.
    pub moves: Vec<DVec3>,
    /// Which time round, at this level.
    pub round: u32,
    /// Residuals of the fitted rows, as far as they have been found, and where they were found last.
    pub residuals: Vec<DVec3>,
    pub hints: Vec<Option<SurfacePoint>>,
    /// What moves answer, until the solve begins with it.
    pub response: Option<Rows>,
    pub solve: Option<Solve>,
    /// Their limit points and the distances of these, as far as they have been found.
    pub measured: Vec<DVec3>,
    pub distances: Vec<f64>,
    /// The greatest of them over each influenced patch, and where, once all are found.
    pub errors: Vec<(FaceCode, f64, DVec3)>,
    pub test_hints: Vec<Option<SurfacePoint>>,
}

/// A level that is being opened.
#[derive(Debug)]
pub(super) struct Opening {
    /// Its faces that are worked on; then what they take along, ring by ring.
    faces: Vec<FaceCode>,
    /// Its faces that are measured in any case.
    watched: Vec<FaceCode>,
    rings: Rings,
    way: Way,
    open: OpenLevel,
    next: Part,
}

/// The faces of a level that a level in work needs, each list ascending.
#[derive(Debug, Default)]
struct Rings {
    /// The faces whose vertices may move.
    around: Vec<FaceCode>,
    /// Two rings around the influenced ones: whole rings around every vertex of these, two levels finer.
    rim: Vec<FaceCode>,
    held: Vec<FaceCode>,
    /// The faces of level `j + 1` that are subdivided, by their place in its mesh.
    quarters: Vec<u32>,
}

/// What is made next.
#[derive(Debug, Default)]
enum Part {
    Rings,
    Root,
    /// The next level on the way to the one that is opened.
    Way,
    Finer,
    Quarters,
    FinestFaces,
    FinestMesh(Box<Quartered>),
    /// From this vertex on.
    FinestStep(u32),
    FinestState,
    FitRows,
    Tested,
    Movable,
    #[default]
    Ready,
}

/// Vertices whose rules are made in one step: some milliseconds.
const VERTICES: u32 = 1 << 15;

impl Opening {
    /// Begins to open `level` with the vertices around `faces` movable, to be measured over what these
    /// influence and over `watched` faces.
    pub fn new(level: u32, faces: Vec<FaceCode>, watched: Vec<FaceCode>) -> Self {
        let open = OpenLevel { level, ..OpenLevel::default() };
        Self { faces, watched, rings: Rings::default(), way: Way::default(), open, next: Part::Rings }
    }

    /// Takes the next step; the level, once it is open.
    pub fn advance(&mut self, surface: &LoopSurface, corners: &CornerTable, details: &Details) -> Option<OpenLevel> {
        let Self { open, rings, .. } = self;
        let OpenLevel { level, levels: [base, finer, finest], steps, .. } = open;
        self.next = match core::mem::take(&mut self.next) {
            Part::Rings => {
                (*rings, open.influenced) = Rings::around(surface, *level, &self.faces, &self.watched);
                self.way = Way::to(surface, *level, &rings.held);
                Part::Root
            }
            Part::Root => {
                *base = chain::root(surface, corners, details);
                Part::Way
            }
            Part::Way => match self.way.step(surface, corners, details, base) {
                Some(finer) => {
                    *base = finer;
                    Part::Way
                }
                None => Part::Finer,
            },
            Part::Finer => {
                (*finer, steps[0]) = chain::refine(surface, corners, details, base, &base.mesh.find_all(&rings.rim));
                Part::Quarters
            }
            Part::Quarters => {
                let quarters = region::neighbourhood(&surface.mesh, *level + 1, &region::children(&open.influenced));
                rings.quarters = finer.mesh.find_all(&quarters);
                Part::FinestFaces
            }
            Part::FinestFaces => Part::FinestMesh(Box::new(rules::quarter(&finer.mesh, &rings.quarters))),
            Part::FinestMesh(quartered) => {
                finest.mesh = rules::settle(surface, &finer.mesh, *quartered);
                Part::FinestStep(0)
            }
            Part::FinestStep(begin) => {
                let all = finest.mesh.vertices.len() as u32;
                let end = all.min(begin + VERTICES);
                rules::extend_step(&mut steps[1], surface, corners, [&finer.mesh, &finest.mesh], begin..end);
                if end < all { Part::FinestStep(end) } else { Part::FinestState }
            }
            Part::FinestState => {
                finest.state = chain::advance(surface, corners, details, &steps[1], finer, &finest.mesh);
                Part::FitRows
            }
            Part::FitRows => {
                let fitted = open.influenced_vertices(1);
                let mesh = &open.levels[1].mesh;
                let is_fitted = |v: u32| fitted[v as usize] && mesh.vertices[v as usize].kind == Kind::Interior;
                open.fit_rows = rules::limit_rows(surface, corners, mesh, is_fitted);
                Part::Tested
            }
            Part::Tested => {
                let measured = open.influenced_vertices(2);
                let mesh = &open.levels[2].mesh;
                let is_tested = |&v: &u32| measured[v as usize] && LimitRows::has_row(mesh, v);
                open.tested = (0..mesh.vertices.len() as u32).filter(is_tested).collect();
                Part::Movable
            }
            Part::Movable => {
                open.addresses = base.mesh.addresses(&surface.mesh);
                open.movable = movable(&base.mesh, &rings.around);
                open.list_active();
                Part::Ready
            }
            Part::Ready => return Some(core::mem::take(open)),
        };
        None
    }
}

impl Rings {
    /// The rings, and the patches that are measured: those that the movable vertices influence, and
    /// those that are `watched`.
    fn around(surface: &LoopSurface, level: u32, faces: &[FaceCode], watched: &[FaceCode]) -> (Self, Vec<FaceCode>) {
        let grow = |faces: &[FaceCode]| region::neighbourhood(&surface.mesh, level, faces);
        // A vertex of N(faces) moves the patches of its two rings.
        let around = grow(faces);
        let mut influenced = grow(&grow(&around));
        if !watched.is_empty() {
            influenced.extend(watched);
            influenced = region::ascending(influenced);
        }
        let rim = grow(&influenced);
        let mut held = grow(&rim);
        if level > 0 {
            held = region::children(&region::parents(&held));
        }
        (Self { around, rim, held, quarters: Vec::new() }, influenced)
    }
}

impl OpenLevel {
    /// The vertices of the level `finer` levels on that lie in an influenced patch.
    fn influenced_vertices(&self, finer: usize) -> Vec<bool> {
        let mesh = &self.levels[finer].mesh;
        let mut inside = vec![false; mesh.vertices.len()];
        // Both ascend: what is passed is passed for good.
        let mut influenced = self.influenced.iter().peekable();
        for (code, corners) in mesh.codes.iter().zip(&mesh.corners) {
            let patch = FaceCode(code.0 >> (2 * finer));
            while influenced.next_if(|&&face| face < patch).is_some() {}
            if influenced.peek() == Some(&&patch) {
                corners.iter().for_each(|&v| inside[v as usize] = true);
            }
        }
        inside
    }

    /// Takes away the movable vertices that the region does not allow.
    pub fn allow(&mut self, surface: &LoopSurface, region: &Region) {
        let mesh = &self.levels[0].mesh;
        let allowed = match region {
            Region::Whole => return,
            Region::Faces(omega) => {
                let level = self.level;
                let inside = |code: FaceCode| omega.binary_search(&FaceCode(code.0 >> (2 * level))).is_ok();
                inner_vertices(mesh, &inside)
            }
            Region::Around { vertex, rings, from_level } => {
                if self.level < *from_level {
                    return;
                }
                let zone = zone(surface, self.level, *vertex, *rings);
                inner_vertices(mesh, &|code| zone.binary_search(&code).is_ok())
            }
        };
        self.movable.retain(|&v| allowed[v as usize]);
        self.list_active();
    }

    fn list_active(&mut self) {
        self.moves = vec![DVec3::ZERO; self.movable.len()];
        self.active = self.movable.iter().map(|&v| (self.level, self.addresses[v as usize])).collect();
        self.active.sort_unstable();
    }
}

/// Keeps where point `i` was found, of which all before it are kept already.
pub(super) fn keep(hints: &mut Vec<Option<SurfacePoint>>, i: usize, at: Option<SurfacePoint>) {
    match hints.get_mut(i) {
        Some(hint) => *hint = at,
        None => hints.push(at),
    }
}

/// The vertices of `faces` that have whole rings and are free to move: not on a plain border, and
/// not where a given one meets it.
fn movable(mesh: &LevelMesh, faces: &[FaceCode]) -> Vec<u32> {
    let mut marked = vec![false; mesh.vertices.len()];
    for face in mesh.find_all(faces) {
        mesh.corners[face as usize].iter().for_each(|&v| marked[v as usize] = true);
    }
    let free = |v: u32| match mesh.vertices[v as usize].kind {
        Kind::Interior => true,
        Kind::Given(g) => mesh.given[g as usize].end != SideEnd::Mixed,
        Kind::Plain | Kind::PlainCorner => false,
    };
    let whole = |v: u32| mesh.vertices[v as usize].ring == RingState::Whole;
    (0..mesh.vertices.len() as u32).filter(|&v| marked[v as usize] && whole(v) && free(v)).collect()
}

/// The vertices all of whose patches (those of two rings) are `inside`.
fn inner_vertices(mesh: &LevelMesh, inside: &dyn Fn(FaceCode) -> bool) -> Vec<bool> {
    let mut inner = vec![true; mesh.vertices.len()];
    for (code, corners) in mesh.codes.iter().zip(&mesh.corners) {
        if !inside(*code) {
            corners.iter().for_each(|&v| inner[v as usize] = false);
        }
    }
    for (v, vertex) in mesh.vertices.iter().enumerate() {
        if vertex.ring == RingState::Cut {
            inner[v] = false;
        }
    }
    // One more ring: a vertex with a neighbour that is not inner moves a patch outside.
    let outer: Vec<bool> = (0..mesh.vertices.len() as u32)
        .map(|v| !inner[v as usize] || mesh.neighbours(v).any(|n| !inner[n as usize]))
        .collect();
    outer.into_iter().map(|o| !o).collect()
}
