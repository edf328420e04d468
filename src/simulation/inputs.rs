//! Inputs: what the solver is given in a frame.

use bevy::math::{Affine3A, DVec3};
use bevy::prelude::*;

use super::coupling::Coupled;
use super::motion::Motion;
use super::share::Share;
use super::slumber::Slumber;
use super::worn::Worn;
use crate::bind::{AnchorSets, Crossfade, Followed, Placement, Skin};
use crate::components::checked::Checked;
use crate::components::{ClothBlend, ClothDetail, ClothInertia, ClothLod, ClothPins};
use crate::solver::anchors::Anchors;
use crate::solver::body::Body;
use crate::solver::evaluate::EvaluateSettings;
use crate::solver::island::{Animation, UntangleSettings};
use crate::solver::ramp::Ramp;
use crate::solver::recover::{Limits, Recovery};
use crate::solver::rest::RestShape;
use crate::solver::settings::{Fabric, Stepping};
use crate::solver::skinned::Skinned;
use crate::solver::step::FrameInput;
use crate::solver::wind::Wind;

/// Frames in which a skinned cloth is put where its skin is. The player of its animation poses it in the first or in the
/// second. In the next the skin takes it along, at its own speed. Then it gets its limits within a quarter of a second, as in
/// o3de.
pub(crate) const FIRST_FRAMES: u32 = 2;

/// Inputs: everything the solver is given in a frame.
#[derive(Component, Clone)]
#[component(clone_behavior = Ignore)]
#[require(Slumber)]
pub(crate) struct ClothInputs {
    /// Whether to simulate at all.
    pub active: bool,
    /// Whether it is left alone until something happens to it.
    pub asleep: bool,
    /// Fabric of this frame, on its way to the one that is wanted.
    pub fabric: Fabric,
    pub ramp: Ramp,
    pub stepping: Stepping,
    pub limits: Limits,
    pub untangle: UntangleSettings,
    pub evaluate: EvaluateSettings,
    pub gravity: Vec3,
    pub time_scale: f32,
    /// How much faster than its clock it is simulated while it warms up (dimensionless).
    pub pace: f32,
    /// For how long it was simulated before it is shown `[s]`; none: it does not warm up.
    pub warmed: Option<f32>,
    /// Whether it stands still for being far away, and is carried along.
    pub carried: bool,
    /// Whether it was carried anywhere in this frame.
    pub rode: bool,
    /// Whether its frames run in the background.
    pub background: bool,
    /// Whether nothing came of that in this frame.
    pub under_way: bool,
    /// Whether the frame under way is of this cloth.
    pub taken: bool,
    /// Time since the end of its last frame that is done, while frames run in the background `[s]`. Anchors and bodies begin
    /// there.
    pub waited: f32,
    /// Targets of its grips at that end `[m]`.
    pub pulled_to: Vec<Vec3>,
    /// The character it belongs to.
    pub character: Option<Entity>,
    /// How much of the motion of its carrier it feels, if that was said.
    pub inertia: Option<ClothInertia>,
    /// How its carrier moved in this frame, unless it jumped; whether it did; and what the cloth was carried along with,
    /// unfelt.
    pub journey: Option<Motion>,
    pub jumped: bool,
    pub carried_by: Option<Motion>,
    /// Level of detail, if it has any.
    pub lod: Option<ClothLod>,
    /// What it costs, and what the budget leaves of it. Whether a body needs it in full.
    pub share: Share,
    pub bears: bool,
    /// Level of detail by distance alone, and the time for which no camera saw it `[s]`.
    pub by_distance: ClothDetail,
    pub unseen_for: f32,
    /// Least jump `[m]` and turn `[rad]` of the carrier that count as a teleport.
    pub teleport: (f32, f32),
    /// The pins that anchors were made from.
    pub pins: ClothPins,
    pub anchors: Anchors,
    pub sets: AnchorSets,
    pub skin: Option<Skin>,
    /// What is asked of the skin, and what the solver is given of it.
    pub followed: Followed,
    pub skinned: Skinned,
    /// Frames since it was bound, as far as they count.
    pub frames: u32,
    /// How much of its limits it has got since (dimensionless, 0 to 1): a skinned cloth begins as its skin.
    pub fade: f32,
    /// Whether a frame was simulated with nothing of its limits left.
    pub on_skin: bool,
    /// How much of it is to be simulated, by [`ClothBlend`], and whether level of detail leaves it only its animation.
    pub blend: ClothBlend,
    pub too_far: bool,
    /// Whether places on the skin are taken out of bodies.
    pub avoids_bodies: bool,
    /// The skeleton, where the cloth is not given it as it is.
    pub crossfade: Crossfade,
    /// Skinning matrices that the cloth is given, in the frame of simulation, and those of the frame before.
    pub joints: Vec<Affine3A>,
    pub joints_before: Vec<Affine3A>,
    /// Where the cloth's own entity or its skin is.
    pub placement: Placement,
    /// Middle of what carries the skin `[m]`, as [`Self::placement`] sees it: how far that went is how far the carrier did.
    pub center: Vec3,
    /// Radius of the ball around the shape at rest `[m]`.
    pub radius: f32,
    /// What was made close to the bones of who wears it.
    pub worn: Worn,
    pub bodies: Vec<Body>,
    /// The entity of each body.
    pub body_entities: Vec<Entity>,
    /// The bodies that take what the cloth gives.
    pub coupled: Coupled,
    pub wind: Wind,
    /// Whether fabric or anchors changed since the solver was prepared.
    pub stale: bool,
    /// Whether the fabric, or how firmly a pin holds, is on its way to what it is to be.
    pub tuned: bool,
    pub checked: Checked,
}

impl ClothInputs {
    /// Inputs of a frame in which the clock of the schedule moves by `dt` `[s]`.
    pub(crate) fn frame(&self, dt: f32) -> FrameInput<'_> {
        let skinned = Some(&self.skinned).filter(|skinned| skinned.is_active());
        FrameInput { dt: dt * self.time_scale, gravity: self.gravity, bodies: &self.bodies, wind: &self.wind, skinned }
    }

    /// Defaults for everything that the frame fills in.
    pub(crate) fn new(
        placement: Placement,
        radius: f32,
        anchors: Anchors,
        sets: AnchorSets,
        skin: Option<Skin>,
        joints: Vec<Affine3A>,
    ) -> Self {
        Self {
            active: true,
            asleep: false,
            fabric: Fabric::default(),
            ramp: Ramp::of_length(2.0 * radius),
            stepping: Stepping::default(),
            limits: Limits::default(),
            untangle: UntangleSettings::default(),
            evaluate: EvaluateSettings::default(),
            gravity: Vec3::ZERO,
            time_scale: 1.0,
            pace: 1.0,
            warmed: None,
            carried: false,
            rode: false,
            background: false,
            under_way: false,
            taken: false,
            waited: 0.0,
            pulled_to: Vec::new(),
            character: None,
            inertia: None,
            journey: None,
            jumped: false,
            carried_by: None,
            lod: None,
            share: Share::default(),
            bears: false,
            by_distance: ClothDetail::Full,
            unseen_for: 0.0,
            teleport: (f32::INFINITY, f32::INFINITY),
            pins: ClothPins::default(),
            anchors,
            sets,
            skin,
            followed: Followed::default(),
            frames: 0,
            fade: 0.0,
            on_skin: false,
            blend: ClothBlend::default(),
            too_far: false,
            avoids_bodies: true,
            skinned: Skinned::of_radius(radius),
            crossfade: Crossfade::of(&joints),
            joints,
            joints_before: Vec::new(),
            placement,
            center: Vec3::ZERO,
            radius,
            worn: Worn::default(),
            bodies: Vec::new(),
            body_entities: Vec::new(),
            coupled: Coupled::default(),
            wind: Wind::default(),
            stale: true,
            tuned: false,
            checked: Checked::default(),
        }
    }

    /// How much of the limits a skinned cloth is to have (dimensionless, 0 to 1).
    pub(crate) fn wanted(&self) -> f32 {
        if self.too_far { 0.0 } else { self.blend.weight }
    }

    /// Whether it has faded into its animation, and is to stay there.
    pub(crate) fn is_animated(&self) -> bool {
        self.on_skin && self.wanted() == 0.0
    }

    /// Takes what it may go from its skin towards what is wanted, in `dt` `[s]`.
    pub(crate) fn advance_fade(&mut self, dt: f32) {
        let (wanted, most, before) = (self.wanted(), self.blend.rate * dt, self.fade);
        self.fade = match self.skin {
            // A skin that just came is not in the pose that it will have.
            Some(_) if self.frames <= FIRST_FRAMES => 0.0,
            Some(_) => self.fade + (wanted - self.fade).clamp(-most, most),
            None => 1.0,
        };
        // It was shown there, so that nothing jumps.
        self.on_skin = self.frames > FIRST_FRAMES && before == 0.0 && self.fade == 0.0;
    }

    /// Whether time passes for the cloth; it does not while it is frozen after `recovery`.
    pub(crate) fn is_live(&self, recovery: &Recovery) -> bool {
        self.active && !self.asleep && !recovery.is_frozen() && self.time_scale > 0.0
    }

    /// Whether the cloth is stepped in a frame in which time passes.
    pub(crate) fn moves(&self, recovery: &Recovery) -> bool {
        self.is_live(recovery) && !self.background
    }

    /// Whether the frame leaves it as it is: there is nothing new to judge or to tell.
    pub(crate) fn is_idle(&self) -> bool {
        self.asleep || self.carried || self.under_way
    }

    /// Whether what carries it is looked at in a frame in which time passes.
    pub(crate) fn is_followed(&self) -> bool {
        self.active && self.time_scale != 0.0 && !self.carried
    }

    /// What carries the cloth as a whole: its entity or skin, or the first target if others hold it all.
    pub(crate) fn carrier(&self) -> Isometry3d {
        let sets = &self.sets.sets;
        match sets.first() {
            Some(first) if self.skin.is_none() && sets.iter().all(|s| s.target.is_some()) => {
                let (_, rotation, translation) = first.at.to_scale_rotation_translation();
                Isometry3d::new(translation, rotation.normalize())
            }
            _ => self.placement.isometry(),
        }
    }

    /// Starts the anchors' frame where the last one ended, and ends it where their targets are now, as seen from `origin`.
    pub(crate) fn aim(&mut self, origin: DVec3) {
        let Anchors { particles, from, to, .. } = &mut self.anchors;
        // In the background a frame may begin long ago.
        if self.waited == 0.0 || from.len() != to.len() {
            core::mem::swap(from, to);
        }
        let AnchorSets { sets, set_of, local, .. } = &self.sets;
        let mut space = (u32::MAX, Affine3A::IDENTITY);
        for (i, to) in to.iter_mut().enumerate() {
            let Some(set) = sets.get(set_of[i] as usize) else { continue };
            *to = match &self.skin {
                Some(skin) if set.target.is_none() => skin.pose(&self.joints, particles[i] as usize),
                _ => {
                    if space.0 != set_of[i] {
                        space = (set_of[i], set.space_from(origin));
                    }
                    let at = space.1.transform_point3(local[i]);
                    // Shown where it is held.
                    let skin = self.skin.as_ref().filter(|_| self.crossfade.is_active());
                    let off = skin.and_then(|skin| skin.motion([self.crossfade.live(), &self.joints], particles[i] as usize));
                    off.map_or(at, |off| off.transform_point3(at))
                }
            };
        }
    }

    /// Starts the frame of the skin where the last one ended, and ends it where the skin is now, as seen from `origin`.
    pub(crate) fn follow(&mut self, rest: &RestShape, origin: DVec3) {
        let mut skinned = core::mem::take(&mut self.skinned);
        let Skinned { from, to, normals_from, normals_to, .. } = &mut skinned;
        core::mem::swap(from, to);
        core::mem::swap(normals_from, normals_to);
        to.clear();
        normals_to.clear();
        if skinned.is_active() {
            let Skinned { from, to, normals_from, normals_to, .. } = &mut skinned;
            to.extend(self.pose(rest, origin));
            normals_to.extend(self.followed.normals.iter().enumerate().map(|(i, &normal)| match &self.skin {
                Some(skin) => skin.turn(&self.joints, i, normal).normalize_or_zero(),
                None => self.placement.rotation * normal,
            }));
            if from.len() != to.len() {
                from.clone_from(to);
            }
            if normals_from.len() != normals_to.len() {
                normals_from.clone_from(normals_to);
            }
        }
        self.skinned = skinned;
    }

    /// Puts anchors and targets where they are now, so that nothing is dragged there in the first frame.
    pub(crate) fn snap_to_targets(&mut self, rest: &RestShape, origin: DVec3) {
        self.aim(origin);
        self.follow(rest, origin);
        self.stay();
    }

    /// Begins the frame where it ends: nothing is dragged along.
    pub(crate) fn stay(&mut self) {
        self.anchors.from.clone_from(&self.anchors.to);
        let Skinned { from, to, normals_from, normals_to, .. } = &mut self.skinned;
        from.clone_from(to);
        normals_from.clone_from(normals_to);
    }

    /// Moves where anchors and targets were last, to be [swapped](Self::aim) in.
    pub(crate) fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        self.anchors.to.iter_mut().chain(&mut self.skinned.to).for_each(|x| *x = motion(*x));
        if self.waited > 0.0 {
            self.anchors.from.iter_mut().chain(&mut self.pulled_to).for_each(|x| *x = motion(*x));
        }
    }

    /// Moves joints along: where they were in the frame before, or where they are.
    pub(crate) fn carry_joints(&mut self, motion: Affine3A, as_they_are: bool) {
        let joints = if as_they_are { &mut self.joints } else { &mut self.joints_before };
        joints.iter_mut().for_each(|joint| *joint = motion * *joint);
        self.crossfade.move_along(motion, as_they_are);
    }

    /// Lets go of the anchors whose sets were released.
    pub(crate) fn drop_released(&mut self) {
        let sets = &self.sets.sets;
        let keep: Vec<bool> = self.sets.set_of.iter().map(|&s| sets.get(s as usize).is_some_and(|set| !set.released)).collect();
        fn filter<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut at = keep.iter();
            list.retain(|_| at.next().copied().unwrap_or(true));
        }
        filter(&mut self.anchors.particles, &keep);
        filter(&mut self.anchors.weights, &keep);
        filter(&mut self.anchors.from, &keep);
        filter(&mut self.anchors.to, &keep);
        filter(&mut self.sets.set_of, &keep);
        filter(&mut self.sets.local, &keep);
        filter(&mut self.sets.weights, &keep);
        self.stale = true;
    }

    /// The pose at rest, or the animated one, in the frame of simulation `[m]`.
    pub(crate) fn pose<'a>(&'a self, rest: &'a RestShape, origin: DVec3) -> impl Iterator<Item = Vec3> + 'a {
        let place = self.placement.in_frame(origin);
        rest.positions.iter().enumerate().map(move |(i, &p)| match &self.skin {
            Some(skin) => skin.pose(&self.joints, i),
            None => place.transform_point3(p),
        })
    }
}

impl Animation for ClothInputs {
    fn position(&self, particle: usize) -> Vec3 {
        self.skin.as_ref().map_or(Vec3::NAN, |skin| skin.pose(&self.joints, particle))
    }
}

impl core::fmt::Debug for ClothInputs {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("ClothInputs").finish_non_exhaustive()
    }
}
