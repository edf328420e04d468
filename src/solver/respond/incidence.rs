//! Which pairs each particle is in: what is cut asks those again, and no others.

use super::contact::Contact;
use crate::solver::topology::NONE;

/// The pairs of each particle, a list for each; and which pairs are due, in a pass and in the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Incidence {
    /// By particle: [`PER_PAIR`] times the number of a pair, plus its place in it; or [`NONE`].
    first: Vec<u32>,
    /// What follows, by pair and place.
    next: Vec<[u32; PER_PAIR]>,
    /// A bit for each pair.
    due: Vec<u64>,
    due_next: Vec<u64>,
    /// Whether the pairs are those that were listed last.
    is_listed: bool,
}

/// Particles of a pair.
const PER_PAIR: usize = 4;

impl Incidence {
    /// Makes room for `particles` and `pairs`.
    pub(super) fn reserve(&mut self, particles: usize, pairs: usize) {
        fn room<T>(of: &mut Vec<T>, count: usize) {
            of.reserve(count.saturating_sub(of.len()));
        }
        room(&mut self.first, particles);
        room(&mut self.next, pairs);
        let words = pairs.div_ceil(u64::BITS as usize);
        room(&mut self.due, words);
        room(&mut self.due_next, words);
    }

    /// Says that the pairs are not those that were listed.
    pub(super) fn forget(&mut self) {
        self.is_listed = false;
    }

    /// Takes in all pairs, unless they are those that were listed last; none is due.
    pub(super) fn list(&mut self, particles: usize, pairs: &[Contact]) {
        let Self { first, next, due, due_next, is_listed } = self;
        let are_these = core::mem::replace(is_listed, true) && (first.len(), next.len()) == (particles, pairs.len());
        if !are_these {
            first.clear();
            first.resize(particles, NONE);
            next.clear();
            for (pair, number) in pairs.iter().zip(0_u32..) {
                next.push(core::array::from_fn(|place| {
                    let entry = PER_PAIR as u32 * number + place as u32;
                    core::mem::replace(&mut first[pair.particles[place] as usize], entry)
                }));
            }
        }
        for due in [due, due_next] {
            due.clear();
            due.resize(pairs.len().div_ceil(u64::BITS as usize), 0);
        }
    }

    /// The pairs that a particle is in.
    pub(super) fn of(&self, particle: u32) -> impl Iterator<Item = usize> + '_ {
        pairs_of(&self.first, &self.next, particle)
    }

    /// Says that the pairs of a particle are due in the next pass, and those after pair `at` in this one, too.
    pub(super) fn ask_again(&mut self, particle: u32, at: Option<usize>) {
        let Self { first, next, due, due_next, .. } = self;
        for pair in pairs_of(first, next, particle) {
            let (word, bit) = (pair / u64::BITS as usize, 1 << (pair % u64::BITS as usize));
            due_next[word] |= bit;
            if at.is_none_or(|at| pair > at) {
                due[word] |= bit;
            }
        }
    }

    /// Begins the next pass.
    pub(super) fn turn(&mut self) {
        core::mem::swap(&mut self.due, &mut self.due_next);
        self.due_next.fill(0);
    }

    /// The first pair that is due in this pass from number `from` on, which is not any more.
    pub(super) fn take(&mut self, from: usize) -> Option<usize> {
        let first = from / u64::BITS as usize;
        let word = first + self.due.get(first..)?.iter().position(|word| *word != 0)?;
        let pair = word * u64::BITS as usize + self.due[word].trailing_zeros() as usize;
        self.due[word] &= self.due[word] - 1;
        Some(pair)
    }
}

/// The pairs in the list of a particle.
fn pairs_of<'a>(first: &[u32], next: &'a [[u32; PER_PAIR]], particle: u32) -> impl Iterator<Item = usize> + use<'a> {
    let mut entry = first[particle as usize];
    core::iter::from_fn(move || {
        (entry != NONE).then(|| {
            let (pair, place) = (entry as usize / PER_PAIR, entry as usize % PER_PAIR);
            entry = next[pair][place];
            pair
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::detect::ProximityKind;

    #[test]
    fn pairs_of_what_was_cut_are_due_in_their_order() {
        let bare = |particles: [u32; 4]| Contact { particles, ..Contact::bare(ProximityKind::VertexFace, 0.01) };
        let pairs: Vec<Contact> = (0..100).map(|i| bare([i, i + 1, i + 2, 200])).collect();
        let mut incidence = Incidence::default();
        incidence.list(201, &pairs);
        let mut of: Vec<usize> = incidence.of(70).collect();
        of.sort_unstable();
        assert_eq!(of, [68, 69, 70]);
        assert_eq!(incidence.of(200).count(), 100);
        assert_eq!(incidence.take(0), None);
        // In this pass the ones that follow, in the next all.
        incidence.ask_again(70, Some(69));
        assert_eq!((incidence.take(0), incidence.take(0)), (Some(70), None));
        incidence.turn();
        let all = core::iter::from_fn(|| incidence.take(0));
        assert_eq!(all.collect::<Vec<_>>(), [68, 69, 70]);
        incidence.ask_again(1, None);
        assert_eq!((incidence.take(0), incidence.take(0)), (Some(0), Some(1)));
        // Others, as many, are listed when they are said to be others.
        let others: Vec<Contact> = pairs.iter().rev().copied().collect();
        incidence.forget();
        incidence.list(201, &others);
        let mut of: Vec<usize> = incidence.of(70).collect();
        of.sort_unstable();
        assert_eq!((of, incidence.take(0)), (vec![29, 30, 31], None));
    }
}
