//! Brings cloths into the order of their layers.

use super::Resolver;
use super::between::cloths;
use super::contour::ContourGraph;
use super::facing::{ONE_WAY, agreement, facing_at, mean};
use super::layers::{Layers, Pair, ordered};
use super::separation::{COVERED, Course, Member, Stray};
use super::view::View;
use crate::solver::scales::ALIGNED;

/// Which side of a contour the inner cloth is on: pairs are named the outer one first.
const INNER: usize = 1;

/// Share of the pins met on the way that must hold both cloths in another order for it to be theirs.
const HELD: f32 = 0.5;

/// The way out of the outer cloth: where the inner one faces, if that is about the same all along, else each particle its own.
/// None where the cloths face opposite ways: what one goes by would drive the other out, too.
fn outward(view: View<'_>, graph: &ContourGraph, set: &[Member], strays: &[Stray]) -> Option<Course> {
    // A stray of the inner cloth only knows the outer one; where it lies on the wrong side they face the same way.
    let mean = mean(facing_at(view, graph, set, INNER).chain(strays.iter().map(|s| view.facing(s.face))));
    if mean.length() > ONE_WAY {
        return Some(Course::Along(mean.normalize_or_zero()));
    }
    (agreement(view, graph, set) > -ALIGNED).then_some(Course::Facing([1.0, -1.0]))
}

impl Resolver {
    /// Plans how cloths get into the order of their layers, in steps of at most `step` `[m]`.
    pub(super) fn order(&mut self, view: View<'_>, step: f32) {
        let Self { graph, between, layers: Layers { plans, pairs, strays, of_pair, .. }, separation, set, .. } = self;
        pairs.retain(|p| plans.is_live(p.plan));
        let at_contours = (0..graph.contours.len()).filter_map(|k| ordered(view.surface, cloths(view, graph, k)?));
        for cloths in at_contours.chain(strays.iter().map(|s| s.0)) {
            if pairs.iter().any(|p| p.cloths == cloths) {
                continue;
            }
            set.clear();
            set.extend(between.of(cloths));
            of_pair.clear();
            of_pair.extend(strays.iter().filter(|s| s.0 == cloths).map(|s| s.1));
            let (mut plan, mut held) = (0, false);
            if let Some(course) = outward(view, graph, set, of_pair) {
                separation.look_from(view, graph, set, of_pair, course);
                held = separation.pins[1] as f32 >= HELD * (separation.pins[0].max(1)) as f32;
                if !held && separation.cost > 0.0 && (set.is_empty() || separation.undone >= COVERED) {
                    plan = plans.carry_out(view, graph, set, separation, step);
                }
            }
            pairs.push(Pair { cloths, plan, held });
        }
        // What nothing is done about is as good as in order.
        strays.retain(|s| pairs.iter().any(|p| p.cloths == s.0 && p.plan != 0));
    }

    /// Cloths whose order of layers is not that of their pins, and is let be: the one that is to be outside first.
    pub fn overruled_layers(&self) -> impl Iterator<Item = [u16; 2]> + '_ {
        self.layers.pairs.iter().filter(|p| p.held).map(|p| p.cloths)
    }

    /// Whether the order of layers takes care of a contour.
    pub(super) fn is_ordered(&self, view: View<'_>, contour: usize) -> bool {
        let pairs = &self.layers.pairs;
        let pair = cloths(view, &self.graph, contour).and_then(|c| ordered(view.surface, c));
        pair.is_some_and(|c| pairs.iter().any(|p| p.cloths == c && p.plan != 0))
    }
}
