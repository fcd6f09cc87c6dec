//! The seed's quasi-interpolation: details by local stencils over residuals.
//!
//! [Litke et al. 2001, Fig. 5] with its misprints mended: interior vertices use
//! `beta = -1 / (2 k)` (exact on cubics for valence 6); irregular ones below level 0 interpolate
//! afterwards; smooth border vertices use the rhombus (exact on quadratics) or seven points (exact
//! on cubics); corners take the mean of their neighbours' details or a stencil of their own.

use glam::DVec3;
use selvedge_components::subdivision::{GivenVertex, Kind, LevelMesh, Origin, SideEnd, masks};

pub use selvedge_components::subdivision::fit::{BoundaryStencil, CornerStencil};

use super::fit::{FitWork, Quantum, Stage};
use super::modify::FIRST_ROUNDS;

/// Weights of [`BoundaryStencil::Quadratic`] on the two interior neighbours and the vertex beyond
/// them: a rhombus, whose fourth point is the border vertex itself, where the residual is zero.
pub const QUADRATIC: [f64; 3] = [-1.0 / 6.0, -1.0 / 6.0, 1.0 / 6.0];

/// Weights of [`BoundaryStencil::Cubic`]: two neighbours, the vertex beyond them and the two beside
/// it, and two of the third row. The only symmetric combination of these seven points that is exact
/// on cubics.
pub const CUBIC: [f64; 7] = [-5.0 / 12.0, -5.0 / 12.0, 0.5, 1.0 / 12.0, 1.0 / 12.0, -1.0 / 12.0, -1.0 / 12.0];

/// Does the rule read the residual at vertex `v` of the finer level?
pub(super) fn is_read(finer: &LevelMesh, v: u32) -> bool {
    matches!(finer.vertices[v as usize].origin, Origin::Vertex(_))
}

impl FitWork {
    /// One pass of the rule: first the quasi-interpolating stencils, then, below level 0, the
    /// interpolating one at irregular vertices.
    pub(super) fn quasi(&mut self, boundary: BoundaryStencil, corner: CornerStencil) -> Quantum {
        let open = &self.open;
        let mesh = &open.levels[0].mesh;
        let residuals = self.residuals_of_level();
        let interpolating = open.level > 0 && open.round == 1;
        let irregular = |v: u32| {
            let vertex = mesh.vertices[v as usize];
            open.level > 0 && vertex.kind == Kind::Interior && vertex.valence != 6
        };
        let stencils = Stencils { mesh, residuals: &residuals };
        let border: Vec<DVec3> =
            mesh.given.iter().map(|given| stencils.border(given, boundary).unwrap_or(DVec3::ZERO)).collect();
        let moves: Vec<DVec3> = open
            .movable
            .iter()
            .map(|&v| match (mesh.vertices[v as usize].kind, interpolating) {
                (Kind::Interior, true) if irregular(v) => stencils.interpolating(v),
                (Kind::Interior, false) if !irregular(v) => stencils.interior(v),
                (Kind::Given(g), false) if mesh.given[g as usize].end == SideEnd::Smooth => -border[g as usize],
                (Kind::Given(_), false) => -stencils.corner(v, &border, corner),
                _ => DVec3::ZERO,
            })
            .collect();
        // Level 0 goes round again as the least-squares rule does: its residuals are not smooth yet.
        let repeat = open.level == 0 && open.round + 1 < FIRST_ROUNDS;
        let more = repeat || !interpolating && open.movable.iter().any(|&v| irregular(v));
        self.take_moves(&moves);
        self.open.round += 1;
        self.go_to(if more { Stage::Correspond } else { Stage::Refine })
    }

    /// The residual at each vertex of the level in work; zero on the borders, and where none was
    /// asked for.
    fn residuals_of_level(&self) -> Vec<DVec3> {
        let open = &self.open;
        let mut residuals = vec![DVec3::ZERO; open.levels[0].mesh.vertices.len()];
        for (&f, &r) in open.fit_rows.vertices.iter().zip(&open.residuals) {
            if let Origin::Vertex(v) = open.levels[1].mesh.vertices[f as usize].origin {
                residuals[v as usize] = r;
            }
        }
        residuals
    }
}

struct Stencils<'a> {
    mesh: &'a LevelMesh,
    residuals: &'a [DVec3],
}

impl Stencils<'_> {
    fn at(&self, v: u32) -> DVec3 {
        self.residuals[v as usize]
    }

    fn sum<const N: usize>(&self, weights: &[f64; N], vertices: [u32; N]) -> DVec3 {
        weights.iter().zip(vertices).fold(DVec3::ZERO, |sum, (&w, v)| sum + w * self.at(v))
    }

    /// Fig. 5a: `(1 - k beta) centre + beta ring`.
    fn interior(&self, v: u32) -> DVec3 {
        let beta = -0.5 / f64::from(self.mesh.vertices[v as usize].valence);
        self.mesh.neighbours(v).fold(1.5 * self.at(v), |sum, n| sum + beta * self.at(n))
    }

    /// Fig. 5d: `(3 + alpha) / 3` of the residual, so that the limit point meets its target.
    fn interpolating(&self, v: u32) -> DVec3 {
        (3.0 + masks::alpha(self.mesh.vertices[v as usize].valence)) / 3.0 * self.at(v)
    }

    /// The detail of a smooth border vertex of valence 4; `None` where there is no stencil for it.
    fn border(&self, given: &GivenVertex, kind: BoundaryStencil) -> Option<DVec3> {
        let mesh = self.mesh;
        let vertex = mesh.vertices[given.vertex as usize];
        if given.end != SideEnd::Smooth || vertex.valence != 4 {
            return None;
        }
        let mut around = mesh.neighbours(given.vertex).skip(1);
        let (n1, n2) = (around.next()?, around.next()?);
        // The second half-edge of the ring goes to n1; the one after it in its face joins n1 to n2.
        let joining = after(mesh.ring(given.vertex).nth(1)?);
        let across = mesh.twin(joining)?;
        let apex = mesh.opposite(across);
        let quadratic = self.sum(&QUADRATIC, [n1, n2, apex]);
        if kind == BoundaryStencil::Quadratic {
            return Some(quadratic);
        }
        Some(self.cubic(n1, n2, apex, across).unwrap_or(quadratic))
    }

    /// [`CUBIC`], where all three rows are regular.
    fn cubic(&self, n1: u32, n2: u32, apex: u32, across: u32) -> Option<DVec3> {
        let mesh = self.mesh;
        // `across` runs n2 -> n1 in the face of the apex.
        let left = mesh.twin(after(across))?;
        let right = mesh.twin(before(across))?;
        let (w1, w2) = (mesh.opposite(left), mesh.opposite(right));
        let z1 = mesh.opposite(mesh.twin(before(left))?);
        let z2 = mesh.opposite(mesh.twin(after(right))?);
        let regular = |&v: &u32| {
            let vertex = mesh.vertices[v as usize];
            vertex.kind != Kind::Interior || vertex.valence == 6
        };
        if ![n1, n2, apex, w1, w2].iter().all(regular) {
            return None;
        }
        Some(self.sum(&CUBIC, [n1, n2, apex, w1, w2, z1, z2]))
    }

    /// The detail of the corner `v` from those of its neighbours along the border, or from the
    /// residuals inside.
    fn corner(&self, v: u32, border: &[DVec3], kind: CornerStencil) -> DVec3 {
        let mesh = self.mesh;
        let detail = |v: u32| match mesh.vertices[v as usize].kind {
            Kind::Given(g) => border[g as usize],
            _ => DVec3::ZERO,
        };
        let ahead = mesh.to(mesh.vertices[v as usize].start);
        let Some(behind) = mesh.previous_on_border(v) else { return DVec3::ZERO };
        let mean = 0.5 * (detail(ahead) + detail(behind));
        if kind == CornerStencil::Mean {
            return mean;
        }
        match mesh.vertices[v as usize].valence {
            3 => {
                let ahead2 = mesh.to(mesh.vertices[ahead as usize].start);
                let smooth = |v: u32| matches!(mesh.vertices[v as usize].kind, Kind::Given(g) if mesh.given[g as usize].end == SideEnd::Smooth);
                match mesh.previous_on_border(behind) {
                    Some(behind2) if smooth(ahead2) && smooth(behind2) => {
                        2.0 * mean - 0.5 * (detail(ahead2) + detail(behind2))
                    }
                    _ => mean,
                }
            }
            2 => self.sharp_corner(v).unwrap_or(mean),
            _ => mean,
        }
    }

    /// Valence 2: `-(3 m - (w1 + w2) / 2) / 6`, where `m` lies across the opposite edge and `w1`,
    /// `w2` beside it; `-m / 6` where those are missing.
    fn sharp_corner(&self, v: u32) -> Option<DVec3> {
        let mesh = self.mesh;
        let opposite = mesh.twin(after(mesh.vertices[v as usize].start))?;
        let m = mesh.opposite(opposite);
        // The two other edges of m's face; beyond each of them, the edge from m on.
        let first = mesh.twin(after(opposite)).and_then(|h| mesh.twin(before(h)).map(|t| mesh.opposite(t)));
        let second = mesh.twin(before(opposite)).and_then(|h| mesh.twin(after(h)).map(|t| mesh.opposite(t)));
        let inside = |v: &u32| mesh.vertices[*v as usize].kind == Kind::Interior;
        Some(match (first.filter(inside), second.filter(inside)) {
            (Some(w1), Some(w2)) => -(3.0 * self.at(m) - 0.5 * (self.at(w1) + self.at(w2))) / 6.0,
            _ => -self.at(m) / 6.0,
        })
    }
}

const fn after(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

const fn before(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}
