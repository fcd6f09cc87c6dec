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
use super::stretch::{Stretch, middle, number};
use super::track::Track;
use super::winding::{Beyond, Ways, Winding};
use crate::parallel::map_dear_in_order;

/// The sets of curves on a surface.
pub(super) struct Sets<'a> {
    mesh: &'a Connectivity,
    track: &'a Track,
    cuts: &'a [Cut],
    beyond: &'a Beyond,
    /// Their names, ascending.
    names: Vec<u32>,
}

/// What stays of a surface, or lies on the other side of one set.
#[derive(Debug)]
pub struct Stays {
    numbers: Winding,
    /// By part of the surface, the number of what stays by all sets, or by all but one.
    wanted: Vec<i32>,
    /// That one's numbers, with its curves turned: what it removes is anywhere but where they are
    /// lowest.
    turned: Option<(Winding, Vec<i32>)>,
}

impl Stays {
    /// Does a place stay in this part of the surface that has this number, and that of the turned set?
    fn holds(&self, part: u32, [number, turned]: [i32; 2]) -> bool {
        let lowest = self.turned.as_ref().map(|(_, lowest)| lowest[part as usize]);
        number - turned == self.wanted[part as usize] && lowest.is_none_or(|lowest| turned > lowest)
    }

    /// Does a place that lies on no way stay?
    pub fn stays(&self, at: SurfacePoint) -> bool {
        let turned = self.turned.as_ref().map_or(0, |(turned, _)| turned.at(at));
        self.holds(self.numbers.part(at.face), [self.numbers.at(at), turned])
    }

    fn is_empty(&self) -> bool {
        self.numbers.highest().iter().zip(&self.wanted).all(|(highest, wanted)| highest < wanted)
    }
}

/// The number on the left of a stretch, and a place there.
type Left = (FaceId, i32);

impl<'a> Sets<'a> {
    pub fn new(mesh: &'a Connectivity, track: &'a Track, cuts: &'a [Cut], beyond: &'a Beyond) -> Self {
        let mut names: Vec<u32> = cuts.iter().map(|cut| cut.set).collect();
        names.sort_unstable();
        names.dedup();
        Self { mesh, track, cuts, beyond, names }
    }

    /// What stays by all sets, or lies on the `other` side of one whose curves are turned, and of each
    /// stretch whether that ends there.
    ///
    /// # Errors
    /// [`RemeshError::DoesNotSeparate`]; [`RemeshError::NothingLeft`] with a curve of the first set
    /// that leaves nothing of what those before it leave.
    pub fn stays(
        &self,
        all: Ways,
        stretches: &[Stretch],
        other: Option<u32>,
    ) -> Result<(Stays, Vec<bool>), RemeshError> {
        let (stays, lefts) = match other {
            None => self.of_first(self.names.len(), all, stretches)?,
            Some(set) => self.beyond(set, all, stretches)?,
        };
        let borders: Vec<bool> =
            stretches.iter().zip(lefts).map(|(stretch, left)| self.is_border(&stays, stretch, left, other)).collect();
        let is_empty = if other.is_some() { !borders.contains(&true) } else { stays.is_empty() };
        if !is_empty {
            return Ok((stays, borders));
        }
        // Of one set the highest number is always somewhere.
        for count in 2..self.names.len() {
            let ways = self.ways(|set| set <= self.names[count - 1]);
            if other.is_none() && self.of_first(count, ways, stretches)?.0.is_empty() {
                return Err(self.nothing_left(self.names[count - 1]));
            }
        }
        Err(self.nothing_left(other.unwrap_or(self.names[self.names.len() - 1])))
    }

    /// Does what stays lie on the left of a stretch, and not on its right?
    fn is_border(&self, stays: &Stays, stretch: &Stretch, (face, number): Left, other: Option<u32>) -> bool {
        let part = stays.numbers.part(face);
        let is_turned = other == Some(self.cuts[stretch.span.cut as usize].set);
        let turned = stays.turned.as_ref().map_or(0, |(turned, _)| match middle(self.track, stretch) {
            Some((way, f)) if is_turned => turned.left_of(&way, f),
            Some((way, f)) => turned.at(SurfacePoint { face: way.leg.face, st: way.leg.from.lerp(way.leg.to, f) }),
            None => i32::MIN,
        });
        let right = [number - 1, turned - i32::from(is_turned)];
        stays.holds(part, [number, turned]) && !stays.holds(part, right)
    }

    /// What lies beyond the curves of `set`, which are turned, and is left by all others.
    fn beyond(&self, set: u32, all: Ways, stretches: &[Stretch]) -> Result<(Stays, Vec<Left>), RemeshError> {
        let (numbers, lefts) = self.noted(self.winding(all, |_| true)?, stretches, |_| true);
        let own = |other| other == set;
        let (turned, beside) = self.noted(self.winding(self.ways(own), own)?, stretches, own);
        let mut lowest = turned.lowest();
        for (face, left) in beside {
            let lowest = &mut lowest[turned.part(face) as usize];
            *lowest = (*lowest).min(left - 1);
        }
        let mut wanted = vec![0; numbers.highest().len()];
        let others: Vec<u32> = self.names.iter().copied().filter(|&name| name != set).collect();
        self.add_highest(&others, stretches, &mut wanted)?;
        Ok((Stays { numbers, wanted, turned: Some((turned, lowest)) }, lefts))
    }

    /// Adds the highest numbers of each of these sets by itself.
    fn add_highest(&self, names: &[u32], stretches: &[Stretch], sums: &mut Vec<i32>) -> Result<(), RemeshError> {
        let all = map_dear_in_order(names.len(), |i| {
            let is_own = |set| set == names[i];
            let (own, _) = self.noted(self.winding(self.ways(is_own), is_own)?, stretches, is_own);
            Ok(own.highest().to_vec())
        });
        for highest in all {
            let highest = highest?;
            sums.resize(highest.len(), 0);
            sums.iter_mut().zip(highest).for_each(|(sum, highest)| *sum += highest);
        }
        Ok(())
    }

    fn nothing_left(&self, set: u32) -> RemeshError {
        RemeshError::NothingLeft { curve: self.cuts.iter().position(|cut| cut.set == set).unwrap_or(0) }
    }

    /// What stays by the first `count` sets, whose ways are given.
    fn of_first(&self, count: usize, ways: Ways, stretches: &[Stretch]) -> Result<(Stays, Vec<Left>), RemeshError> {
        let names = &self.names[..count];
        let mut wanted: Vec<i32> = Vec::new();
        if let [_, _, ..] = names {
            self.add_highest(names, stretches, &mut wanted)?;
        }
        let is_among = |set| names.binary_search(&set).is_ok();
        let (numbers, lefts) = self.noted(self.winding(ways, is_among)?, stretches, is_among);
        if names.len() < 2 {
            wanted = numbers.highest().to_vec();
        }
        Ok((Stays { numbers, wanted, turned: None }, lefts))
    }

    fn ways(&self, wanted: impl Fn(u32) -> bool) -> Ways {
        let cuts = self.cuts;
        Ways::of_curves(self.track, self.mesh.face_count(), |curve| wanted(cuts[curve as usize].set))
    }

    fn winding(&self, ways: Ways, wanted: impl Fn(u32) -> bool) -> Result<Winding, RemeshError> {
        Winding::new(self.mesh, ways, self.beyond).map_err(|face| self.not_separating(face, wanted))
    }

    /// The numbers with those on the left of the stretches of some sets taken note of, which are
    /// returned, too.
    fn noted(&self, mut winding: Winding, stretches: &[Stretch], wanted: impl Fn(u32) -> bool) -> (Winding, Vec<Left>) {
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
            Winding::new(self.mesh, Ways::new(&one, self.mesh.face_count()), self.beyond).is_err()
        };
        let mut own = (0..self.track.tracks.len()).filter(of_set);
        let curve = own.clone().find(alone).or(own.next()).unwrap_or(0);
        let own = self.track.points.iter().filter(|p| p.cut as usize == curve);
        let near = own.clone().find(|p| p.legs.iter().any(|l| l.face == face)).or(own.clone().next());
        RemeshError::DoesNotSeparate { curve, at: near.map_or(DVec3::NAN, |p| p.position) }
    }
}
