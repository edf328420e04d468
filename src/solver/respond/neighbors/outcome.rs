//! What asking leaves came to, in the order in which they were asked.

use super::Contacts;
use crate::solver::respond::contact::Contact;

/// Pairs listed for each particle, at most; what comes on top, in cloth that is crushed, is left to untangling.
const MOST_PAIRS: usize = 32;

/// What asking leaves came to.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// Pairs that may touch.
    pub(super) pairs: Vec<Contact>,
    /// Faces that are close, or may come close.
    pub(super) close: Vec<[u32; 2]>,
    /// Whether primitives lie in the same place.
    pub(super) coincide: bool,
    /// How many pairs may still be listed.
    pub(super) room: usize,
}

impl Outcome {
    /// Nothing yet, and room for so many pairs.
    pub(super) fn begin(&mut self, room: usize) {
        self.pairs.clear();
        self.close.clear();
        (self.coincide, self.room) = (false, room);
    }

    /// How many pairs of so many particles may be listed beside those that the contacts have.
    pub(super) fn room(particles: usize, contacts: &Contacts) -> usize {
        (MOST_PAIRS * particles).saturating_sub(contacts.len())
    }

    /// Puts all of it into the contacts.
    pub(super) fn drain_into(&mut self, contacts: &mut Contacts) {
        contacts.coincide |= self.coincide;
        contacts.close.append(&mut self.close);
        self.pairs.drain(..).for_each(|pair| contacts.push(pair));
    }
}
