//! The other sides of trims that are made together: asked beforehand how fine they are, and made in the end.

use selvedge_components::trim::{Sides, TrimFault, TrimQuantum};

use super::super::other::{OtherWork, cutting};
use super::{Blamed, TrimWork};
use crate::subdivision::remesh::{Fineness, RelaxQuantum, RemeshQuantum};

impl TrimWork {
    /// Makes the next other side that is wanted by itself, one step further, to learn how fine it is: its knots
    /// will be those of what stays. Tells whether there is more to do. One that cannot be made asks for nothing;
    /// it will say why in its turn.
    pub(super) fn ask_other_sides(&mut self) -> bool {
        let (asked, begun) = core::mem::take(&mut self.alone);
        let Some(trim) = (asked..self.members.len()).find(|&trim| self.wants_other(trim)) else {
            self.alone.0 = self.members.len();
            return false;
        };
        let begun = begun.map_or_else(|| cutting(self, trim, None).map(Box::new), Ok);
        let step = begun.and_then(|mut alone| {
            let laid = alone.advance()? == RemeshQuantum::Laid;
            let done = laid && matches!(alone.relax()?, RelaxQuantum::Finished(_));
            Ok((alone, done))
        });
        self.alone = match step {
            Ok((alone, false)) => (trim, Some(alone)),
            Ok((alone, true)) => {
                self.asked.extend(alone.fineness());
                (trim + 1, None)
            }
            Err(_) => (trim + 1, None),
        };
        true
    }

    fn wants_other(&self, trim: usize) -> bool {
        self.members[trim].options.sides == Sides::Both
    }

    /// How fine the cage has to be along the curves, as far as that is known.
    pub(in super::super) fn asked(&self) -> &[Fineness] {
        &self.asked
    }

    /// The first trim whose other side is wanted and was not begun.
    pub(super) fn next_other(&self) -> Option<usize> {
        let begin = self.others.last().map_or(0, |other| other.trim + 1);
        (begin..self.members.len()).find(|&trim| self.wants_other(trim))
    }

    /// One quantum more of the other sides.
    pub(super) fn advance_others(&mut self) -> Result<TrimQuantum, Blamed> {
        let of_other = |trim, why| Blamed { trim, with: None, why: TrimFault::OtherSide { why: Box::new(why) } };
        if let Some(mut other) = self.others.pop_if(|other| !other.is_done()) {
            let (trim, step) = (other.trim, other.advance(self));
            self.others.push(other);
            let step = step.map_err(|why| of_other(trim, why))?;
            let is_last = self.next_other().is_none();
            return Ok(if step == TrimQuantum::Finished && !is_last { TrimQuantum::More } else { step });
        }
        let (Some(trim), Some(remeshed)) = (self.next_other(), self.remeshed.clone()) else {
            return Ok(TrimQuantum::Finished);
        };
        self.others.push(OtherWork::new(self, trim, remeshed).map_err(|why| of_other(trim, why))?);
        Ok(TrimQuantum::More)
    }

    /// The other sides that are made.
    pub fn others(&self) -> &[OtherWork] {
        &self.others
    }
}
