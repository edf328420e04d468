//! Contours take turns where a frame may not be at all of them.
//!
//! ```text
//!   contours by their first edge:   0 ─► 1 ─► 2 ─► … ─► k │ work is spent       next iteration:  k ─► k + 1 ─► … ─► 0 ─► …
//! ```

use glam::Vec4;

use super::contour::ContourGraph;
use super::view::View;
use super::{Method, ResolveSettings, Resolver};

impl Resolver {
    /// One iteration on every contour, or on as many as there may be work for: the next one goes on where this one stopped.
    pub(super) fn undo_contours(&mut self, view: View<'_>, previous: &[Vec4], settings: &ResolveSettings) {
        // What was begun goes on in any case.
        self.effort.spend(self.plans.moves() + self.layers.plans.moves());
        let count = self.graph.contours.len();
        let edge = |graph: &ContourGraph, k: usize| graph.nodes_of(k).first().map_or(0, |&i| view.crossings[i as usize].edge);
        // They stand in the order of their first edges.
        let first = if self.next > 0 { (0..count).find(|&k| edge(&self.graph, k) >= self.next).unwrap_or(0) } else { 0 };
        let mut order = (first..count).chain(0..first);
        for (done, k) in order.by_ref().enumerate() {
            if done > 0 && self.effort.is_spent() {
                self.next = edge(&self.graph, k);
                self.tracked.now[k].waits = true;
                order.for_each(|k| self.tracked.now[k].waits = true);
                self.deferred = (count - done) as u32;
                return;
            }
            let step = settings.step * self.graph.contours[k].edge;
            match settings.method {
                #[cfg(feature = "research")]
                Method::History => {}
                #[cfg(feature = "research")]
                Method::LocalGradient => self.follow_each_gradient(view, k, step),
                #[cfg(feature = "research")]
                Method::GlobalGradient => self.follow_global_gradient(view, k, step, false, settings),
                Method::ByEndType => self.undo(view, previous, k, step, settings),
            }
            self.count_visits();
        }
        (self.deferred, self.next) = (0, 0);
    }

    /// Counts what was done since the last time.
    pub(super) fn count_visits(&mut self) {
        let Self { patch, flood, separation, plans, layers, .. } = self;
        for visits in
            [&mut patch.visits, &mut flood.visits, &mut separation.visits, &mut plans.visits, &mut layers.plans.visits]
        {
            self.effort.spend(core::mem::take(visits));
        }
    }

    /// Contours that the last iteration put off, since there was too much work for a frame.
    #[must_use]
    pub fn deferred(&self) -> u32 {
        self.deferred
    }
}
