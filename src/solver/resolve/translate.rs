//! The cheapest way apart: of a few candidate directions, the one along which the least area has the least way to go.
//!
//! This is a capped version of *Type-Free Global Intersection Analysis* (2026). Candidates are both normals of both sides at
//! the contour, and the direction taken before. Two cloths may face many ways along the contour, as tubes do. Each particle
//! then goes along the normal of the face that it meets, in or out. The chosen displacement is carried out over several
//! iterations.

use glam::Vec3;

use super::Resolver;
use super::between::cloths;
use super::facing::{ONE_WAY, agreement, facing_at, mean};
use super::separation::{Course, Member};
use super::tracked::Strategy;
use super::view::View;
use crate::solver::scales::ALIGNED;
use crate::solver::verdict::Escalation;

/// How much cheaper another direction must be than the one taken before.
const HYSTERESIS: f32 = 0.25;

impl Resolver {
    /// Plans the cheapest separation of a contour, to be carried out in steps of at most `step` `[m]`. All other contours
    /// between the same two cloths are taken with it if one direction undoes them all. Returns whether there is one.
    pub(super) fn translate_apart(&mut self, view: View<'_>, contour: usize, step: f32) -> bool {
        let mut set = core::mem::take(&mut self.set);
        set.clear();
        let pair = cloths(view, &self.graph, contour).filter(|c| c[0] != c[1]);
        let between_two = pair.is_some();
        let mut done = false;
        if let Some(pair) = pair.filter(|&pair| self.between.may_work(pair)) {
            set.extend(self.between.of(pair));
            done = set.len() > 1 && self.translate_all(view, &set, between_two, step);
            if !done {
                // Nor does it for the next of them: each looks through all.
                self.between.note_failure(pair);
            }
        }
        if !done {
            set.clear();
            set.push(Member { contour, flip: 0 });
            done = self.translate_all(view, &set, between_two, step);
        }
        self.set = set;
        done
    }

    fn translate_all(&mut self, view: View<'_>, set: &[Member], between_two: bool, step: f32) -> bool {
        let Self { graph, plans, separation, tracked, escalation, .. } = self;
        let before = set.iter().fold(Vec3::ZERO, |sum, m| {
            let tracked = &tracked.now[m.contour];
            let weight = if tracked.plan > 0 { graph.contours[m.contour].count as f32 } else { 0.0 };
            sum + tracked.mean_direction * if m.flip == 0 { weight } else { -weight }
        });
        let means = [0, 1].map(|side| mean(facing_at(view, graph, set, side)));
        let [n, m] = means.map(Vec3::normalize_or_zero);
        // What a cloth crosses of itself may be short and bent.
        let one_way = !between_two || means.iter().any(|mean| mean.length() > ONE_WAY);
        let (mut best, mut least) = (None, f32::INFINITY);
        let mut look = |course: Course, most: f32| separation.look(view, graph, set, course, most).then_some(separation.cost);
        let across = n.cross(m).normalize_or_zero();
        let more = [across, n.cross(across), m.cross(across), Vec3::X, Vec3::Y, Vec3::Z].map(|d| [d, -d]).into_iter().flatten();
        let more = more.filter(|_| *escalation >= Escalation::Candidates);
        let directions = [before.normalize_or_zero(), n, -n, m, -m].into_iter().chain(more).filter(|_| one_way);
        let agree = agreement(view, graph, set);
        let signs = [1.0, -1.0].into_iter().filter(|_| !one_way && agree.abs() > ALIGNED);
        let courses = directions.map(Course::Along).chain(signs.map(|sign| Course::Facing([sign, -sign * agree.signum()])));
        for (k, course) in courses.enumerate() {
            if course != Course::Along(Vec3::ZERO)
                && let Some(cost) = look(course, least)
            {
                (best, least) = (Some(course), cost * if k == 0 && one_way { HYSTERESIS } else { 1.0 });
            }
        }
        let Some(course) = best else { return false };
        look(course, f32::INFINITY);
        let cost = separation.cost;
        let plan = plans.carry_out(view, graph, set, separation, step);
        let direction = if let Course::Along(direction) = course { direction } else { Vec3::ZERO };
        for member in set {
            let tracked = &mut tracked.now[member.contour];
            if tracked.strategy != Strategy::Translate {
                tracked.switch_to(Strategy::Translate);
            }
            tracked.progress(cost);
            tracked.mean_direction = if member.flip == 0 { direction } else { -direction };
            tracked.plan = plan;
        }
        true
    }
}
