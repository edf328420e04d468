//! Prepare: how much detail the budget leaves to every cloth.
//!
//! ```text
//! measure   what a cloth costs: per frame, and per share of its substeps; over a quarter of a second
//! move out  what is large and does not even fit by itself: it runs in the background
//! lower     what is worth least for what it saves, until the sum fits
//! raise     what is worth most for what it takes, as long as it still fits with room to spare
//! ```

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

use super::lod::{LEAST_RATE, bears, eyes};
use crate::components::checked::Checked;
use crate::components::{Cloth, ClothBudget, ClothCollisionLayers, ClothDetail, ClothLoading, ClothPriority, ClothReport};
use crate::islands::ClothIslands;
use crate::notices::Notices;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace, WorldBodies};
use crate::time::ClothTime;

/// Share of the budget that is filled (dimensionless): what costs somewhat more in the next frame still fits, and what was
/// raised stays.
const FILLED: f32 = 0.9;
/// Share of what is filled below which a cloth in the background is stepped in the frame again (dimensionless), so that it does
/// not come and go.
const RETURNS: f32 = 0.5;
/// Whether something can run in the background at all.
const HAS_THREADS: bool = cfg!(all(feature = "multi_threaded", not(target_family = "wasm")));
/// What a cloth is worth that no camera sees, over what it would be (dimensionless).
const UNSEEN: f64 = 0.01;
/// Nearest distance that counts `[m]`.
const NEAREST: f64 = 0.1;

/// Cloths that can touch each other, which take as many substeps as one another.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Its island; none for a cloth alone.
    island: Option<u32>,
    /// What distance leaves of it, and what the budget does.
    by_distance: ClothDetail,
    by_budget: ClothDetail,
    /// Least share of the substeps that is taken (dimensionless).
    least: f32,
    /// Costs in a frame, whatever its substeps, and of all of its substeps `[ms]`.
    fixed: f32,
    steps: f32,
    /// What its detail is worth, in squares of the angle that it fills.
    worth: f64,
    /// What it would cost awake, as [`Self::fixed`] and [`Self::steps`] `[ms]`.
    awake: [f32; 2],
    /// Particles, and those of cloths whose cost is not known yet (count).
    particles: usize,
    unknown: usize,
    /// Whether all of it can be stepped in the background.
    movable: bool,
    /// Whether it was there in the last frame.
    was_in_background: bool,
    /// Whether it may be given less detail, and more.
    may_fall: bool,
    may_rise: bool,
}

impl Group {
    fn detail(&self) -> ClothDetail {
        self.by_distance.max(self.by_budget)
    }

    /// Cost at a level `[ms]`.
    fn cost(&self, detail: ClothDetail) -> f32 {
        if detail == ClothDetail::Still { 0.0 } else { self.fixed + self.steps * detail.share().max(self.least) }
    }

    /// Whether its frames are to run in the background, by a budget of `ms`. It is as large as what is prepared there, and its
    /// cost is not known, or not even the least detail that moves fits.
    fn is_too_much(&self, ms: f32, loading: &ClothLoading) -> bool {
        let is_large = |particles: usize| particles > 0 && particles >= loading.in_background_from as usize;
        let most = FILLED * ms * if self.was_in_background { RETURNS } else { 1.0 };
        let [fixed, steps] = self.awake;
        let least = fixed + steps * ClothDetail::Quarter.share().max(self.least);
        self.movable && (is_large(self.unknown) || (is_large(self.particles) && least > most))
    }

    /// Leaves everything of it, at no cost: it runs in the background.
    fn move_out(&mut self) {
        (self.fixed, self.steps, self.by_budget) = (0.0, 0.0, ClothDetail::Full);
        (self.may_fall, self.may_rise) = (false, false);
    }

    /// What is lost of its worth between two levels, for each millisecond.
    fn loss(&self, [fine, coarse]: [ClothDetail; 2]) -> f64 {
        self.worth * f64::from(fine.share() - coarse.share()) / f64::from(self.cost(fine) - self.cost(coarse)).max(1.0e-9)
    }
}

/// The level after one that is coarser by one.
fn coarser(detail: ClothDetail) -> Option<ClothDetail> {
    ClothDetail::ALL.get(detail as usize + 1).copied()
}

/// Changes what the budget of `ms` leaves of groups.
fn govern(groups: &mut [Group], ms: f32) {
    let mut total: f32 = groups.iter().map(|group| group.cost(group.detail())).sum();
    if total > ms {
        while total > FILLED * ms {
            let step = |group: &Group| Some([group.detail(), coarser(group.detail())?]);
            let open = groups.iter_mut().filter(|group| group.may_fall && step(group).is_some());
            let least = open.min_by(|a, b| {
                let loss = |group: &Group| step(group).map_or(f64::INFINITY, |step| group.loss(step));
                loss(a).total_cmp(&loss(b))
            });
            let Some((group, [from, to])) = least.and_then(|group| step(group).map(|step| (group, step))) else { return };
            total -= group.cost(from) - group.cost(to);
            group.by_budget = to;
        }
        return;
    }
    loop {
        // What distance keeps coarse is not raised.
        let step = |group: &Group| {
            let finer = ClothDetail::ALL.get((group.by_budget as usize).checked_sub(1)?).copied()?;
            Some([finer.max(group.by_distance), group.detail()])
        };
        let extra = |group: &Group| step(group).map_or(f32::INFINITY, |[to, from]| group.cost(to) - group.cost(from));
        let fits = |group: &&mut Group| group.may_rise && total + extra(group) <= FILLED * ms;
        let most = groups.iter_mut().filter(fits).max_by(|a, b| {
            let gain = |group: &Group| step(group).map_or(0.0, |step| group.loss(step));
            gain(a).total_cmp(&gain(b))
        });
        let Some(group) = most else { return };
        total += extra(group);
        group.by_budget = ClothDetail::ALL[(group.by_budget as usize).saturating_sub(1)];
    }
}

/// What it works with.
#[derive(Default)]
pub(crate) struct Buffers {
    checked: Checked,
    watched_from: Vec<DVec3>,
    groups: Vec<Group>,
    /// Which groups run in the background.
    moved_out: Vec<bool>,
    /// The group of each cloth.
    of: Vec<usize>,
}

/// What the budget goes by.
#[derive(SystemParam)]
pub(crate) struct Known<'w> {
    budget: Option<Res<'w, ClothBudget>>,
    loading: Res<'w, ClothLoading>,
    islands: Res<'w, ClothIslands>,
    bodies: Res<'w, WorldBodies>,
}

impl Known<'_> {
    /// Whether a frame of the island of a cloth is under way in the background.
    fn is_under_way(&self, place: &IslandPlace) -> bool {
        let island = place.island.and_then(|(island, _)| self.islands.list.get(island as usize));
        island.is_some_and(|island| island.background.frame.is_some())
    }
}

/// Finds out what every cloth costs, and what the budget leaves of it.
pub(crate) fn budget(
    time: Res<ClothTime>,
    known: Known,
    mut notices: ResMut<Notices>,
    cameras: Query<(&Camera, &GlobalTransform), Without<Camera2d>>,
    mut cloths: Query<
        (
            Entity,
            Option<&Name>,
            Option<&ViewVisibility>,
            Option<&ClothPriority>,
            Option<&ClothCollisionLayers>,
            &IslandPlace,
            &ClothRest,
            &ClothParticles,
            &mut ClothInputs,
            &mut ClothReport,
        ),
        With<Cloth>,
    >,
    mut buffers: Local<Buffers>,
) {
    let Some(budget) = &known.budget else {
        for (.., place, _, _, mut inputs, mut report) in &mut cloths {
            measure(&mut inputs, &report, time.delta_secs());
            inputs.share.lift();
            inputs.background = known.is_under_way(place);
            catch_up(&mut inputs, time.delta_secs());
            if report.by_budget != ClothDetail::Full {
                report.by_budget = ClothDetail::Full;
            }
        }
        return;
    };
    let Buffers { checked, watched_from, groups, moved_out, of } = &mut *buffers;
    checked.clear();
    let ms = budget.checked(checked);
    notices.clamped_in::<ClothBudget>(checked);
    eyes(&cameras, watched_from);
    groups.clear();
    of.clear();
    for (entity, name, seen, priority, layers, place, rest, particles, mut inputs, report) in &mut cloths {
        let inputs = &mut *inputs;
        measure(inputs, &report, time.delta_secs());
        checked.clear();
        let priority = priority.map_or(1.0, |priority| priority.checked(checked));
        notices.clamped(entity, name, "cloth", checked);
        let at = DVec3::from(Vec3::from(inputs.placement.isometry().translation));
        let (low, high) = place.bounds.unwrap_or((at, at));
        let distances = watched_from.iter().map(|eye| eye.clamp(low, high).distance(*eye));
        let distance = distances.fold(f64::INFINITY, f64::min).max(NEAREST);
        let distance = if distance.is_finite() { distance } else { 1.0 };
        // What warms up is hidden by that alone.
        let seen = watched_from.is_empty() || inputs.warmed.is_some() || seen.is_none_or(|seen| seen.get());
        let seen = if seen { 1.0 } else { UNSEEN };
        let worth = f64::from(priority) * seen * (f64::from(inputs.radius) / distance).powi(2);
        let island = place.island.map(|(island, _)| island);
        // Those alone are looked for nowhere: there may be thousands.
        let listed = island.and_then(|_| groups.iter().position(|group| group.island == island));
        let number = listed.unwrap_or(groups.len());
        if listed.is_none() {
            groups.push(Group {
                island,
                by_distance: ClothDetail::Still,
                by_budget: ClothDetail::Still,
                least: 0.0,
                fixed: 0.0,
                steps: 0.0,
                worth: 0.0,
                awake: [0.0; 2],
                particles: 0,
                unknown: 0,
                movable: true,
                was_in_background: false,
                may_fall: true,
                may_rise: true,
            });
        }
        let group = &mut groups[number];
        let [fixed, steps] = inputs.share.cost.unwrap_or_default();
        group.by_distance = group.by_distance.min(inputs.by_distance);
        group.by_budget = group.by_budget.min(inputs.share.detail);
        group.least = group.least.max(LEAST_RATE / inputs.stepping.substep_rate.max(LEAST_RATE));
        // What sleeps or is held where it is costs nothing.
        let costs = if report.asleep { 0.0 } else { 1.0 };
        group.fixed += costs * fixed;
        group.steps += costs * steps;
        group.worth += worth;
        group.awake[0] += fixed;
        group.awake[1] += steps;
        group.particles += rest.0.positions.len();
        let costs_time = inputs.is_live(&particles.sim.recovery) && !inputs.carried && !inputs.is_animated();
        if costs_time && !inputs.share.is_known() {
            group.unknown += rest.0.positions.len();
        }
        // What takes cloth along does so in every frame, and bodies that it moves wait for it.
        let follows =
            inputs.skin.is_some() || inputs.skinned.is_active() || inputs.inertia.is_some() || inputs.warmed.is_some();
        let bears = || bears(entity, (low, high), layers, inputs, &known.bodies);
        group.movable &= HAS_THREADS && !place.alone && !follows && !bears();
        group.was_in_background |= inputs.share.to_background;
        group.may_fall &= inputs.share.may_fall() && !inputs.bears;
        group.may_rise &= inputs.share.may_rise() && !inputs.bears;
        of.push(number);
    }
    moved_out.clear();
    for group in groups.iter_mut() {
        let moves_out = group.is_too_much(ms, &known.loading);
        if moves_out {
            group.move_out();
        }
        moved_out.push(moves_out);
    }
    govern(groups, ms);
    for ((.., place, _, _, mut inputs, mut report), number) in cloths.iter_mut().zip(of.iter()) {
        let (detail, moved_out) = (groups[*number].by_budget, moved_out[*number]);
        // A frame under way is done first.
        inputs.background = moved_out || known.is_under_way(place);
        catch_up(&mut inputs, time.delta_secs());
        let share = &mut inputs.share;
        share.to_background = moved_out;
        if share.detail != detail {
            share.change(detail);
        }
        if report.by_budget != detail {
            report.by_budget = detail;
        }
    }
}

/// The first frame of `dt` `[s]` after those in the background covers the time since the last of them.
fn catch_up(inputs: &mut ClothInputs, dt: f32) {
    if !inputs.background {
        inputs.time_scale *= 1.0 + inputs.waited / dt;
    }
}

/// Takes in what the last frame of a cloth cost, `dt` `[s]` after the one before; nothing while one is under way.
fn measure(inputs: &mut ClothInputs, report: &ClothReport, dt: f32) {
    if !inputs.under_way {
        let frames = inputs.share.frames;
        inputs.share.measure(report, dt * frames);
    }
}

#[cfg(test)]
mod tests {
    use super::ClothDetail::{Full, Quarter, Still};
    use super::*;

    fn group(worth: f64) -> Group {
        Group {
            island: None,
            by_distance: Full,
            by_budget: Full,
            least: 0.0,
            fixed: 0.1,
            steps: 0.3,
            worth,
            awake: [0.1, 0.3],
            particles: 100,
            unknown: 0,
            movable: false,
            was_in_background: false,
            may_fall: true,
            may_rise: true,
        }
    }

    fn total(groups: &[Group]) -> f32 {
        groups.iter().map(|group| group.cost(group.detail())).sum()
    }

    /// Lets seconds pass until nothing changes any more; how many that took.
    fn settle(groups: &mut [Group], ms: f32) -> u32 {
        for second in 0..100 {
            let before: Vec<ClothDetail> = groups.iter().map(|group| group.by_budget).collect();
            groups.iter_mut().for_each(|group| group.may_rise = true);
            govern(groups, ms);
            let changes = groups.iter().zip(&before).filter(|(group, before)| group.by_budget != **before);
            if changes.count() == 0 {
                return second;
            }
        }
        panic!("it never settles");
    }

    #[test]
    fn a_crowd_fits_its_budget_and_what_matters_most_keeps_most() {
        // A hundred, ever farther away: 40 ms in full.
        let mut groups: Vec<Group> = (1..=100).map(|i| group(1.0 / f64::from(i * i))).collect();
        let seconds = settle(&mut groups, 4.0);
        assert!(total(&groups) <= 4.0 && total(&groups) > 3.2, "{} ms", total(&groups));
        assert!(seconds <= 2, "{seconds} s");
        assert!(groups.windows(2).all(|pair| pair[0].by_budget <= pair[1].by_budget), "{groups:?}");
        assert!(groups[0].by_budget == Full && groups[99].by_budget == Still);
        // There is room again: all comes back.
        settle(&mut groups, 100.0);
        assert!(groups.iter().all(|group| group.by_budget == Full));
    }

    #[test]
    fn what_is_raised_stays_where_costs_tremble() {
        let mut groups: Vec<Group> = (1..=10).map(|i| group(f64::from(i))).collect();
        settle(&mut groups, 2.0);
        let mut changes = [0; 10];
        for scale in [1.05, 0.97, 1.08, 0.95, 1.02, 0.96, 1.07, 0.95, 1.08, 1.0] {
            let before: Vec<ClothDetail> = groups.iter().map(|group| group.by_budget).collect();
            groups.iter_mut().for_each(|group| (group.fixed, group.steps) = (0.1 * scale, 0.3 * scale));
            govern(&mut groups, 2.0);
            let now = groups.iter().zip(&before).map(|(group, before)| u32::from(group.by_budget != *before));
            changes.iter_mut().zip(now).for_each(|(changes, now)| *changes += now);
        }
        assert!(changes.iter().all(|changes| *changes <= 1), "{changes:?}");
    }

    #[test]
    fn what_matters_least_falls_again_before_what_matters_more() {
        let mut groups = [group(1.0), group(0.001)];
        govern(&mut groups, 0.7);
        assert_eq!(groups.map(|group| group.by_budget), [Full, Quarter]);
        // It has just fallen, and costs more than was thought.
        groups[1].may_rise = false;
        groups[1].fixed = 0.3;
        govern(&mut groups, 0.7);
        assert_eq!(groups.map(|group| group.by_budget), [Full, Still]);
        // It is not raised before a while has passed.
        govern(&mut groups, 100.0);
        assert_eq!(groups[1].by_budget, Still);
    }

    #[test]
    fn what_may_not_change_or_is_coarse_for_its_distance_is_left_alone() {
        let bears = Group { may_fall: false, may_rise: false, ..group(0.001) };
        let mut groups = [group(1.0), bears, Group { by_distance: Quarter, ..group(0.01) }];
        govern(&mut groups, 0.7);
        assert_eq!(groups.map(|group| group.by_budget), [Quarter, Full, Still]);
        // Nothing is left to lower, and nothing is without cost.
        let mut nothing = [Group { fixed: 0.0, steps: 0.0, ..group(1.0) }];
        govern(&mut nothing, 0.01);
        assert_eq!(nothing[0].by_budget, Full);
        govern(&mut [], 1.0);
    }

    #[test]
    fn what_is_large_and_does_not_fit_by_itself_moves_out_and_comes_back_when_it_clearly_does() {
        let loading = ClothLoading { in_background_from: 100 };
        // At a quarter of its substeps it takes 0.175 ms.
        let mut large = Group { movable: true, ..group(1.0) };
        assert!(large.is_too_much(0.19, &loading) && !large.is_too_much(0.2, &loading));
        large.was_in_background = true;
        assert!(large.is_too_much(0.38, &loading) && !large.is_too_much(0.4, &loading));
        assert!(!Group { particles: 99, ..large }.is_too_much(0.01, &loading), "it is small");
        assert!(!Group { movable: false, ..large }.is_too_much(0.01, &loading));
        // What it costs is not known.
        let new = Group { awake: [0.0; 2], unknown: 100, ..large };
        assert!(new.is_too_much(1000.0, &loading) && !Group { unknown: 99, ..new }.is_too_much(1000.0, &loading));
        // What is out costs nothing, and is not lowered.
        large.move_out();
        let mut groups = [large, group(1.0)];
        govern(&mut groups, 0.2);
        assert_eq!(groups.map(|group| group.by_budget), [Full, Quarter]);
        assert!(total(&groups) < 0.2);
    }
}
