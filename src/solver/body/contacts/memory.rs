//! What is known of a contact from one frame to the next: its load, and on which side of a surface the particle was.

use glam::Vec3;

use super::{BodyContacts, Candidate};

impl BodyContacts {
    /// Passes on what is known of the candidates of a `part` (body, index), the last that were listed. Parts come in ascending
    /// order: those of the frame before have been looked through up to `known`. Returns where the places of its candidates
    /// begin, for a surface.
    pub(super) fn remember(
        &mut self,
        part: (u32, u32),
        known: &mut usize,
        candidates: (u32, u32),
        is_surface: bool,
    ) -> Option<u32> {
        while self.parts_before.get(*known).is_some_and(|p| (p.body, p.index) < part) {
            *known += 1;
        }
        let before = self.parts_before.get(*known).filter(|p| (p.body, p.index) == part);
        if let Some(before) = before {
            keep_loads(&self.candidates_before, before.candidates, &mut self.candidates[candidates.0 as usize..]);
        }
        let places = is_surface.then(|| {
            let first = self.places.len();
            self.places.resize(first + (candidates.1 - candidates.0) as usize, Vec3::INFINITY);
            first as u32
        });
        if let (Some(now), Some(before)) = (places, before)
            && let Some(was) = before.places
        {
            let was = self.places_before.get(was as usize..).unwrap_or(&[]);
            let before = self.candidates_before.get(before.candidates.0 as usize..before.candidates.1 as usize);
            let places = &mut self.places[now as usize..];
            keep_places(before.unwrap_or(&[]), was, &self.candidates[candidates.0 as usize..], places);
        }
        places
    }
}

/// Passes on the loads of contacts that stay; both lists are in the order of particles.
fn keep_loads(before: &[Candidate], (first, end): (u32, u32), now: &mut [Candidate]) {
    let mut before = before.get(first as usize..end as usize).unwrap_or(&[]).iter().filter(|c| c.load > 0.0).peekable();
    for candidate in now {
        while before.next_if(|old| old.particle < candidate.particle).is_some() {}
        if let Some(old) = before.next_if(|old| old.particle == candidate.particle) {
            (candidate.load, candidate.plane) = (old.load, old.plane);
        }
    }
}

/// Passes on the last known places of particles that stay; both lists are in the order of particles.
fn keep_places(before: &[Candidate], places_before: &[Vec3], now: &[Candidate], places: &mut [Vec3]) {
    let mut before = before.iter().zip(places_before).peekable();
    for (candidate, place) in now.iter().zip(places) {
        while before.next_if(|(old, _)| old.particle < candidate.particle).is_some() {}
        if let Some((_, was)) = before.next_if(|(old, _)| old.particle == candidate.particle) {
            *place = *was;
        }
    }
}
