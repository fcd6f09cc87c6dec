//! Limit points at the corners of any faces of any levels.
//!
//! One level mesh per level, each just wide enough: a level holds the faces asked for, the ancestors
//! of finer ones, and around both as many neighbours as whole rings take. So the work is in
//! proportion to the faces asked for, wherever they are.

use glam::DVec3;
use selvedge_components::subdivision::{FaceCode, LimitRows, NONE, Origin, Scheme, limit_frame};

use super::reach::union;
use super::{Subject, TriangulateError};
use crate::parallel::map_in_order;
use crate::subdivision::chain::{self, Level};
use crate::subdivision::region;

/// The levels over some faces, with the limit points of their corners.
#[derive(Debug)]
pub struct Pyramid {
    /// From level 0 on, as deep as was asked for or as details made it.
    pub floors: Vec<Floor>,
}

/// One level of a [`Pyramid`].
#[derive(Debug)]
pub struct Floor {
    /// Faces, vertices and control points.
    pub level: Level,
    /// The faces asked for, as indices into the mesh, in the order in which they were asked for.
    pub faces: Vec<u32>,
    /// By vertex of the mesh: the limit point, where a face asked for has it as a corner.
    pub limit: Vec<DVec3>,
    asked: Vec<Asked>,
}

/// What is known of a vertex on one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// Nobody asks.
    No,
    /// Its limit point is found on this level.
    Here,
    /// On a coarser one.
    Coarser,
    /// On a finer one, since finer details move it.
    Finer,
}

impl Pyramid {
    /// The levels over the faces that `wanted` lists for every level, ascending.
    ///
    /// # Errors
    /// [`TriangulateError::LimitNotFinite`].
    pub fn new(subject: &Subject, wanted: &[Vec<FaceCode>]) -> Result<Self, TriangulateError> {
        let mut pyramid = Self { floors: raise(subject, wanted) };
        pyramid.ask(subject);
        pyramid.find(subject);
        pyramid.check()?;
        Ok(pyramid)
    }

    /// The limit points of the corners of a face asked for.
    #[inline]
    pub fn corners(&self, level: usize, face: u32) -> [DVec3; 3] {
        let floor = &self.floors[level];
        floor.level.mesh.corners[face as usize].map(|v| floor.limit[v as usize])
    }

    /// Names every vertex asked for, on the level where its limit point is found, by calling
    /// `name(level, vertex)` for each, coarse levels first; on other levels it has the same name.
    /// Returns the names by level and vertex; [`NONE`] for vertices not asked for.
    pub fn name(&self, mut name: impl FnMut(usize, u32) -> u32) -> Vec<Vec<u32>> {
        let mut names: Vec<Vec<u32>> = Vec::with_capacity(self.floors.len());
        for (l, floor) in self.floors.iter().enumerate() {
            let mut here = vec![NONE; floor.asked.len()];
            for v in 0..floor.asked.len() as u32 {
                here[v as usize] = match floor.asked[v as usize] {
                    Asked::Here => name(l, v),
                    Asked::Coarser => names[l - 1][floor.coarser(v) as usize],
                    Asked::No | Asked::Finer => NONE,
                };
            }
            names.push(here);
        }
        self.hand_down(&mut names);
        names
    }

    /// Hands what is known on a level to the coarser vertices that wait for it.
    fn hand_down<T: Copy>(&self, values: &mut [Vec<T>]) {
        for l in (1..self.floors.len()).rev() {
            let (coarse, fine) = values.split_at_mut(l);
            for (v, vertex) in self.floors[l].level.mesh.vertices.iter().enumerate() {
                if let Origin::Vertex(p) = vertex.origin
                    && self.floors[l - 1].asked[p as usize] == Asked::Finer
                {
                    coarse[l - 1][p as usize] = fine[0][v];
                }
            }
        }
    }

    /// Decides for every vertex whether, and on which level, its limit point is found.
    fn ask(&mut self, subject: &Subject) {
        let waits: Vec<Vec<bool>> = self.floors.iter().map(|f| f.waiting(subject)).collect();
        for l in 0..self.floors.len() {
            let (coarser, finer) = self.floors.split_at_mut(l);
            let floor = &mut finer[0];
            for f in 0..floor.faces.len() {
                for v in floor.level.mesh.corners[floor.faces[f] as usize] {
                    floor.asked[v as usize] = Asked::Here;
                }
            }
            for v in 0..floor.asked.len() as u32 {
                let above = match floor.level.mesh.vertices[v as usize].origin {
                    Origin::Vertex(p) => Some(p as usize),
                    _ => None,
                };
                let asked = &mut floor.asked[v as usize];
                if above.is_some_and(|p| coarser[l - 1].asked[p] == Asked::Finer) {
                    *asked = Asked::Here;
                }
                if *asked == Asked::No {
                    continue;
                }
                if waits[l][v as usize] {
                    *asked = Asked::Finer;
                } else if above.is_some_and(|p| !waits[l - 1][p]) {
                    *asked = Asked::Coarser;
                }
            }
        }
        // What a finer level asks of a coarser one.
        for l in (1..self.floors.len()).rev() {
            let (coarser, finer) = self.floors.split_at_mut(l);
            for v in 0..finer[0].asked.len() as u32 {
                if finer[0].asked[v as usize] != Asked::Coarser {
                    continue;
                }
                let p = finer[0].coarser(v);
                let final_above = match coarser[l - 1].level.mesh.vertices[p as usize].origin {
                    Origin::Vertex(q) => !waits[l - 2][q as usize],
                    _ => false,
                };
                coarser[l - 1].asked[p as usize] = if final_above { Asked::Coarser } else { Asked::Here };
            }
        }
    }

    fn find(&mut self, subject: &Subject) {
        for l in 0..self.floors.len() {
            let (coarser, finer) = self.floors.split_at_mut(l);
            let floor = &mut finer[0];
            floor.find_here(subject);
            for v in 0..floor.asked.len() as u32 {
                if floor.asked[v as usize] == Asked::Coarser {
                    floor.limit[v as usize] = coarser[l - 1].limit[floor.coarser(v) as usize];
                }
            }
        }
        let mut limits: Vec<Vec<DVec3>> = self.floors.iter_mut().map(|f| core::mem::take(&mut f.limit)).collect();
        self.hand_down(&mut limits);
        for (floor, limit) in self.floors.iter_mut().zip(limits) {
            floor.limit = limit;
        }
    }

    fn check(&self) -> Result<(), TriangulateError> {
        for (l, floor) in self.floors.iter().enumerate() {
            for &f in &floor.faces {
                if let Some(&at) = self.corners(l, f).iter().find(|x| !x.is_finite()) {
                    let face = floor.level.mesh.codes[f as usize].root_face(l as u32);
                    return Err(TriangulateError::LimitNotFinite { face, at });
                }
            }
        }
        Ok(())
    }

    /// The normals at the vertices that [`Pyramid::name`] names, by their names.
    pub fn normals(&self, subject: &Subject, names: &[Vec<u32>], count: usize) -> Vec<DVec3> {
        let mut all = vec![DVec3::ZERO; count];
        for (floor, names) in self.floors.iter().zip(names) {
            let here: Vec<u32> =
                (0..floor.asked.len() as u32).filter(|&v| floor.asked[v as usize] == Asked::Here).collect();
            let scheme = Scheme { surface: subject.surface, corners: &subject.corners };
            let Level { mesh, state } = &floor.level;
            let found = map_in_order(here.len(), |i| limit_frame(scheme, mesh, state, here[i]));
            for (&v, frame) in here.iter().zip(found) {
                all[names[v as usize] as usize] = frame.map_or(DVec3::ZERO, |frame| frame.normal());
            }
        }
        all
    }
}

impl Floor {
    fn new(level: Level, wanted: &[FaceCode]) -> Self {
        let vertices = level.mesh.vertices.len();
        let faces = locate(&level.mesh.codes, wanted);
        Self { level, faces, limit: vec![DVec3::ZERO; vertices], asked: vec![Asked::No; vertices] }
    }

    /// The vertex of the level before that `v` stands for; `v` itself where there is none.
    fn coarser(&self, v: u32) -> u32 {
        match self.level.mesh.vertices[v as usize].origin {
            Origin::Vertex(p) => p,
            _ => v,
        }
    }

    /// By vertex: do finer details move its limit point?
    fn waiting(&self, subject: &Subject) -> Vec<bool> {
        let mesh = &self.level.mesh;
        let mut waits = vec![false; mesh.vertices.len()];
        for &(code, corners) in subject.reach.waiting(mesh.level) {
            let Some(face) = mesh.find(code) else { continue };
            for (corner, &v) in mesh.corners[face as usize].iter().enumerate() {
                waits[v as usize] |= corners >> corner & 1 == 1;
            }
        }
        waits
    }

    fn find_here(&mut self, subject: &Subject) {
        let mesh = &self.level.mesh;
        let here = |v: u32| self.asked[v as usize] == Asked::Here;
        let rows = LimitRows::new(subject.surface, &subject.corners, mesh, here);
        for (&v, x) in rows.vertices.iter().zip(rows.apply(&self.level.state)) {
            self.limit[v as usize] = x;
        }
        for given in &mesh.given {
            self.limit[given.vertex as usize] = given.sample;
        }
    }

    /// Which edges of a face of the mesh lie on a border.
    pub fn borders(&self, face: u32) -> [bool; 3] {
        [0, 1, 2].map(|edge| self.level.mesh.border(3 * face + edge).is_some())
    }
}

/// The indices in `codes` of `faces`; both ascend.
pub fn locate(codes: &[FaceCode], faces: &[FaceCode]) -> Vec<u32> {
    let mut at = 0;
    faces
        .iter()
        .filter_map(|f| {
            while at < codes.len() && codes[at] < *f {
                at += 1;
            }
            (codes.get(at) == Some(f)).then_some(at as u32)
        })
        .collect()
}

/// Builds the level meshes, coarse to fine.
///
/// A level refines the faces that have finer ones below them and all that share a vertex with one.
/// Their children hold two rings around the finer faces, since one coarse ring is two fine ones:
/// whole rings for the corners of the faces asked for, and for those of every face refined next.
fn raise(subject: &Subject, wanted: &[Vec<FaceCode>]) -> Vec<Floor> {
    let below = ancestors(subject, wanted);
    let asked = |l: usize| wanted.get(l).map_or(&[][..], Vec::as_slice);
    let root = chain::root(subject.surface, &subject.corners, &subject.surface.details);
    let mut floors = vec![Floor::new(root, asked(0))];
    for (l, split) in below.iter().enumerate() {
        let coarse = &floors[l].level;
        let faces = with_neighbours(coarse, &locate(&coarse.mesh.codes, split));
        let (finer, _) = chain::refine(subject.surface, &subject.corners, &subject.surface.details, coarse, &faces);
        floors.push(Floor::new(finer, asked(l + 1)));
    }
    floors
}

/// By level: the faces that have something finer to be found below them.
fn ancestors(subject: &Subject, wanted: &[Vec<FaceCode>]) -> Vec<Vec<FaceCode>> {
    let mut present = wanted.to_vec();
    while present.last().is_some_and(Vec::is_empty) {
        present.pop();
    }
    follow_details(subject, wanted, &mut present);
    let mut below = vec![Vec::new(); present.len().saturating_sub(1)];
    for l in (0..below.len()).rev() {
        let finer = match below.get(l + 1) {
            Some(split) => union(&present[l + 1], split),
            None => present[l + 1].clone(),
        };
        below[l] = region::parents(&finer);
    }
    below
}

/// Adds, for corners whose limit points wait for finer details, the faces down to these.
fn follow_details(subject: &Subject, wanted: &[Vec<FaceCode>], present: &mut Vec<Vec<FaceCode>>) {
    let mut followed: Vec<(FaceCode, usize)> = Vec::new();
    let mut l = 0;
    while l < present.len() {
        let level = l as u32;
        let mut next: Vec<(FaceCode, usize)> = Vec::new();
        if !subject.reach.waiting(level).is_empty() {
            let own = wanted.get(l).into_iter().flatten().flat_map(|&f| (0..3).map(move |c| (f, c)));
            for (face, corner) in own.chain(followed) {
                if subject.reach.waits(level, face) >> corner & 1 == 1 {
                    next.push((face.child(corner), corner));
                }
            }
        }
        if !next.is_empty() {
            let faces = region::ascending(next.iter().map(|n| n.0).collect());
            match present.get_mut(l + 1) {
                Some(present) => *present = union(present, &faces),
                None => present.push(faces),
            }
        }
        followed = next;
        l += 1;
    }
}

/// `faces` and all that share a vertex with one of them, ascending.
fn with_neighbours(level: &Level, faces: &[u32]) -> Vec<u32> {
    let mesh = &level.mesh;
    if faces.len() == mesh.corners.len() {
        return faces.to_vec();
    }
    let mut marked = vec![false; mesh.vertices.len()];
    for &f in faces {
        mesh.corners[f as usize].iter().for_each(|&v| marked[v as usize] = true);
    }
    (0..mesh.corners.len() as u32)
        .filter(|&f| mesh.corners[f as usize].iter().any(|&v| marked[v as usize]) && mesh.refinable(f))
        .collect()
}
