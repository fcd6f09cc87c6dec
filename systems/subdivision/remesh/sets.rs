//! # Sets: what stays of a surface that several sets of curves cut
//!
//! Each set, such as the curves of one trim, leaves a part of the surface by itself: where its own
//! number is highest ([`winding`](super::winding)). What stays is common to all. There the number of
//! all curves together is the sum of the highest numbers of the sets, and nowhere is it greater; so
//! one field of numbers tells what stays, and those of the sets are asked for their highest alone.

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId};
use selvedge_components::subdivision::remesh::RemeshError;

use super::Cut;
use super::contour::{Stretch, number};
use super::track::Track;
use super::winding::{Ways, Winding};

/// The sets of curves on a surface.
pub(super) struct Sets<'a> {
    mesh: &'a Connectivity,
    track: &'a Track,
    cuts: &'a [Cut],
    /// Their names, ascending.
    names: Vec<u32>,
}

/// What stays of a surface.
#[derive(Debug)]
pub struct Stays {
    numbers: Winding,
    /// By part of the surface, the number of what stays.
    wanted: Vec<i32>,
}

impl Stays {
    /// Does a place of `face` stay that has this number?
    pub fn is_wanted(&self, face: FaceId, number: i32) -> bool {
        number == self.wanted[self.numbers.part(face) as usize]
    }

    /// Does a place that lies on no way stay?
    pub fn stays(&self, at: SurfacePoint) -> bool {
        self.is_wanted(at.face, self.numbers.at(at))
    }

    fn is_empty(&self) -> bool {
        self.numbers.highest().iter().zip(&self.wanted).all(|(highest, wanted)| highest < wanted)
    }
}

impl<'a> Sets<'a> {
    pub fn new(mesh: &'a Connectivity, track: &'a Track, cuts: &'a [Cut]) -> Self {
        let mut names: Vec<u32> = cuts.iter().map(|cut| cut.set).collect();
        names.sort_unstable();
        names.dedup();
        Self { mesh, track, cuts, names }
    }

    /// What stays by all sets, and with it the number on the left of each stretch, with its face.
    ///
    /// # Errors
    /// [`RemeshError::DoesNotSeparate`]; [`RemeshError::NothingLeft`] with a curve of the first set
    /// that leaves nothing of what those before it leave.
    pub fn stays(&self, all: Ways, stretches: &[Stretch]) -> Result<(Stays, Vec<(FaceId, i32)>), RemeshError> {
        let (stays, numbers) = self.of_first(self.names.len(), all, stretches)?;
        if !stays.is_empty() {
            return Ok((stays, numbers));
        }
        // Of one set the highest number is always somewhere.
        for count in 2..self.names.len() {
            let ways = self.ways(|set| set <= self.names[count - 1]);
            if self.of_first(count, ways, stretches)?.0.is_empty() {
                return Err(self.nothing_left(count));
            }
        }
        Err(self.nothing_left(self.names.len()))
    }

    fn nothing_left(&self, count: usize) -> RemeshError {
        let newest = self.names[count - 1];
        RemeshError::NothingLeft { curve: self.cuts.iter().position(|cut| cut.set == newest).unwrap_or(0) }
    }

    /// What stays by the first `count` sets, whose ways are given.
    fn of_first(
        &self,
        count: usize,
        ways: Ways,
        stretches: &[Stretch],
    ) -> Result<(Stays, Vec<(FaceId, i32)>), RemeshError> {
        let names = &self.names[..count];
        let mut wanted: Vec<i32> = Vec::new();
        if let [_, _, ..] = names {
            for &name in names {
                let own = self.winding(self.ways(|set| set == name), |set| set == name)?;
                let (own, _) = self.noted(own, stretches, |set| set == name);
                wanted.resize(own.highest().len(), 0);
                wanted.iter_mut().zip(own.highest()).for_each(|(sum, highest)| *sum += highest);
            }
        }
        let is_among = |set| names.binary_search(&set).is_ok();
        let numbers = self.winding(ways, is_among)?;
        let (numbers, found) = self.noted(numbers, stretches, is_among);
        if names.len() < 2 {
            wanted = numbers.highest().to_vec();
        }
        Ok((Stays { numbers, wanted }, found))
    }

    fn ways(&self, wanted: impl Fn(u32) -> bool) -> Ways {
        let cuts = self.cuts;
        Ways::of_curves(self.track, self.mesh.face_count(), |curve| wanted(cuts[curve as usize].set))
    }

    fn winding(&self, ways: Ways, wanted: impl Fn(u32) -> bool) -> Result<Winding, RemeshError> {
        Winding::new(self.mesh, ways).map_err(|face| self.not_separating(face, wanted))
    }

    /// The numbers with those on the left of the stretches of some sets taken note of, which are
    /// returned, too.
    fn noted(
        &self,
        mut winding: Winding,
        stretches: &[Stretch],
        wanted: impl Fn(u32) -> bool,
    ) -> (Winding, Vec<(FaceId, i32)>) {
        let own = stretches.iter().filter(|s| wanted(self.cuts[s.span.cut as usize].set));
        let found: Vec<_> = own.map(|stretch| number(self.track, &winding, stretch)).collect();
        found.iter().for_each(|&(face, number)| winding.note(face, number));
        (winding, found)
    }

    /// The first of the `wanted` sets' curves that does not separate the surface by itself, or of
    /// several the first.
    fn not_separating(&self, face: FaceId, wanted: impl Fn(u32) -> bool) -> RemeshError {
        let of_set = |c: &usize| wanted(self.cuts[*c].set);
        let alone = |c: &usize| {
            let mut one = self.track.clone();
            one.points.iter_mut().filter(|p| p.cut as usize != *c).for_each(|p| p.legs.clear());
            Winding::new(self.mesh, Ways::new(&one, self.mesh.face_count())).is_err()
        };
        let mut own = (0..self.track.tracks.len()).filter(of_set);
        let curve = own.clone().find(alone).or(own.next()).unwrap_or(0);
        let own = self.track.points.iter().filter(|p| p.cut as usize == curve);
        let near = own.clone().find(|p| p.legs.iter().any(|l| l.face == face)).or(own.clone().next());
        RemeshError::DoesNotSeparate { curve, at: near.map_or(DVec3::NAN, |p| p.position) }
    }
}
