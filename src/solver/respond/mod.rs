//! Respond: cloth rests on cloth, and folds on itself.
//!
//! ```text
//! once a frame   Contacts::find    boxes swept by the motion foreseen ─► pairs that may touch, each with the side it is on
//! each substep   Contacts::solve   closest points again ─► pushed one thickness apart ─► friction
//! ```
//!
//! A pair keeps its side: who finds itself behind the face it was in front of, having gone through it and not around it, is brought back to the
//! front. So one look a frame is enough, as long as it sees everything that can be met before the next. Pairs of a tangle have no right side; they are left to
//! [`resolve`](crate::solver::resolve).
//!
//! Distances are between centres: the thickness of a pair is the mean of those of its two cloths.

mod contact;
mod find;

use glam::{Vec3, Vec4};

use crate::solver::body::Touch;
use crate::solver::rest::NONE;
use contact::Contact;
pub use find::{Finder, Moment};

/// Pairs that may touch before the next frame, and the particles they are made of.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    pairs: Vec<Contact>,
    /// Particle of each slot, in the order in which pairs ask for them.
    particles: Vec<u32>,
    /// Slot of each particle, or [`NONE`].
    slots: Vec<u32>,
    /// Positions [m] with inverse masses [1/kg], now and at the start of the substep; by slot.
    now: Vec<Vec4>,
    old: Vec<Vec4>,
    /// Pairs that touched in the last [`Self::solve`].
    touching: u32,
}

impl Contacts {
    /// Forgets all pairs.
    pub fn clear(&mut self) {
        for &p in &self.particles {
            self.slots[p as usize] = NONE;
        }
        self.particles.clear();
        self.pairs.clear();
        self.touching = 0;
    }

    /// Number of pairs that may touch.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether nothing can touch.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Pairs that touched in the last [`Self::solve`].
    #[must_use]
    pub fn touching(&self) -> u32 {
        self.touching
    }

    fn slot(&mut self, particle: u32) -> u32 {
        let slot = &mut self.slots[particle as usize];
        if *slot == NONE {
            *slot = self.particles.len() as u32;
            self.particles.push(particle);
        }
        *slot
    }

    /// Keeps all pairs apart at the end of a substep of `h` [s]. `read` gives the position ([m], `w` inverse mass) and the position at the start of
    /// the substep of a particle of the surface; `write` takes back both.
    pub fn solve(&mut self, h: f32, read: impl Fn(u32) -> (Vec4, Vec4), mut write: impl FnMut(u32, Vec4, Vec4)) {
        self.now.clear();
        self.old.clear();
        for &p in &self.particles {
            let (now, old) = read(p);
            self.now.push(now);
            self.old.push(old);
        }
        self.touching = 0;
        for pair in &mut self.pairs {
            self.touching += u32::from(pair.solve(h, &mut self.now, &mut self.old));
        }
        for (i, &p) in self.particles.iter().enumerate() {
            write(p, self.now[i], self.old[i]);
        }
    }
}
impl Contacts { #[allow(missing_docs)] pub fn debug(&self)->Vec<(bool,[u32;4],f32,f32,Vec3)>{ self.pairs.iter().map(|p|(p.kind==crate::solver::detect::ProximityKind::VertexFace,p.slots.map(|s|self.particles[s as usize]),p.thickness,p.load,p.normal)).collect() } }
