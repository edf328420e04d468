//! Cross-fade: bones that are elsewhere from one frame to the next are given to the cloth on their way there.
//!
//! A clip that begins, or takes over without a fade of its own, moves every bone at once. Cloth between the bones would end up
//! on the wrong side of some. The skeleton that the solver sees goes to the new pose within a quarter of a second. The shown
//! cloth is carried onto the skin as it is.
//!
//! ```text
//!   J'ᵣ = Jᵣ    J'ᵢ = J'ₚ · lerp(Lᵢ, Jₚ⁻¹ Jᵢ, s)    r: root, p: the joint above i, Lᵢ: joint i as p saw it when the fade began
//!   shown = A A'⁻¹ x                               A, A': the skin at a particle, as it is and as the solver sees it
//! ```
//!
//! A new cloth begins in the bind pose: there it was made, and lies on the side of the bones where it belongs.

use bevy::math::{Affine3A, DVec3, Mat3A, Vec3A};
use bevy::prelude::*;

use super::skin::{Skin, Transforms, joints_above};
use crate::solver::body::Pose;
use crate::solver::scales::RESPONSE_TIME;

/// Time in which a turn at the speed of a [jump](Crossfade::begin_after_jump) is one `[s]`: a frame of 60 Hz. At more frames a
/// second a step of a clip that is not interpolated turns as fast.
const LEAST_FRAME: f32 = 1.0 / 60.0;

/// The skeleton that a cloth is given, as far as it is not the one that is there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crossfade {
    /// Joints and the joints above them, from the roots down.
    hierarchy: Vec<(u16, Option<u16>)>,
    /// Each of [`Self::hierarchy`], as the joint above saw it when the fade began.
    from: Vec<Transform>,
    /// Time until bones begin to move `[s]`.
    waits: f32,
    /// Time from then until they are there `[s]`; none: they are.
    left: Option<f32>,
    /// Skinning matrices of the skeleton that is there, in the frame of simulation, and those of the frame before.
    live: Vec<Affine3A>,
    live_before: Vec<Affine3A>,
    /// Where [`Self::live`] is seen from `[m]`.
    origin: DVec3,
}

impl Crossfade {
    /// Of a skeleton with these skinning matrices.
    pub(crate) fn of(live: &[Affine3A]) -> Self {
        Self { live: live.to_vec(), live_before: live.to_vec(), ..Self::default() }
    }

    /// Whether the cloth is given another skeleton than the one that is there, or was in the frame before.
    pub(crate) fn is_active(&self) -> bool {
        self.left.is_some()
    }

    /// Skinning matrices of the skeleton that is there.
    pub(crate) fn live(&self) -> &[Affine3A] {
        &self.live
    }

    /// Time until bones begin to move, and from then until they are there `[s]`.
    pub(crate) fn times_left(&self) -> [f32; 2] {
        [self.waits, self.left.unwrap_or(0.0)]
    }

    /// Goes along with the frame of simulation.
    pub(crate) fn shift(&mut self, shift: Vec3) {
        self.live.iter_mut().chain(&mut self.live_before).for_each(|joint| joint.translation -= Vec3A::from(shift));
    }

    /// The skeleton goes along with the cloth: as it was in the frame before, or as it is.
    pub(crate) fn move_along(&mut self, motion: Affine3A, as_it_is: bool) {
        let which = if as_it_is { &mut self.live } else { &mut self.live_before };
        which.iter_mut().for_each(|joint| *joint = motion * *joint);
    }

    /// Begins the frame: reads where the joints are, as seen from `origin` `[m]`.
    pub(crate) fn read(&mut self, skin: &Skin, transforms: &Transforms, origin: DVec3) {
        self.live_before.clone_from(&self.live);
        skin.matrices(transforms, origin, &mut self.live);
        self.origin = origin;
    }

    /// Reads them again, if they are seen from elsewhere by now.
    pub(crate) fn read_again(&mut self, skin: &Skin, transforms: &Transforms, origin: DVec3) {
        if self.origin != origin {
            skin.matrices(transforms, origin, &mut self.live);
            self.origin = origin;
        }
    }

    /// Begins in the bind pose, where the root is; with the [times](Self::times_left) that others of its character have, if
    /// there are any. A skeleton that `comes` was nowhere before.
    pub(crate) fn begin_in_bind_pose(&mut self, skin: &Skin, comes: bool, times: Option<[f32; 2]>, parents: &Query<&ChildOf>) {
        if comes {
            self.live_before.clone_from(&self.live);
        }
        self.begin(skin, &vec![Affine3A::IDENTITY; self.live.len()], parents);
        let [waits, left] = times.unwrap_or([RESPONSE_TIME; 2]);
        (self.waits, self.left) = (waits, self.left.map(|_| left).filter(|left| *left > 0.0));
    }

    /// Begins a cross-fade at the joints that the cloth had until now, if a bone that `matters` jumped. A jump is a turn
    /// against the first joint, in `dt` `[s]`, that is faster than `spin` `[rad/s]`. A cross-fade that still waits goes to the
    /// new pose when it has waited.
    pub(crate) fn begin_after_jump(
        &mut self,
        skin: &Skin,
        joints: &[Affine3A],
        (spin, dt): (f32, f32),
        matters: impl Fn(u16) -> bool,
        parents: &Query<&ChildOf>,
    ) {
        if self.waits <= 0.0 && joints.len() == self.live.len() && self.turned(spin * dt.max(LEAST_FRAME)).any(matters) {
            self.begin(skin, joints, parents);
        }
    }

    /// Gives the cloth the skeleton that is there.
    pub(crate) fn end(&mut self, joints: &mut Vec<Affine3A>) {
        (self.waits, self.left) = (0.0, None);
        joints.clone_from(&self.live);
    }

    fn begin(&mut self, skin: &Skin, joints: &[Affine3A], parents: &Query<&ChildOf>) {
        self.hierarchy = hierarchy(skin, parents);
        let at = |joint: u16| joints[usize::from(joint)] * skin.bind(joint);
        let seen = |&(joint, above): &(u16, Option<u16>)| match above {
            Some(above) => local(at(above), at(joint)),
            None => Transform::IDENTITY,
        };
        self.from = self.hierarchy.iter().map(seen).collect();
        // Roots alone are where they are.
        let fades = self.hierarchy.iter().any(|(_, above)| above.is_some());
        (self.waits, self.left) = (0.0, fades.then_some(RESPONSE_TIME));
    }

    /// The joints that turned against the first by more than `most` `[rad]` since the frame before.
    fn turned(&self, most: f32) -> impl Iterator<Item = u16> {
        let size = |of: &Mat3A| dot(of, of);
        let back = match (self.live.first(), self.live_before.first()) {
            (Some(root), Some(before)) if most < core::f32::consts::PI => before.matrix3 * root.matrix3.inverse(),
            _ => Mat3A::NAN,
        };
        // The trace of a rotation is 1 + 2 cos. What is not finite did not turn.
        let least = (1.0 + 2.0 * most.cos()) / 3.0;
        (0..).zip(self.live.iter().zip(&self.live_before)).filter_map(move |(joint, (now, before))| {
            let (now, before) = (back * now.matrix3, before.matrix3);
            (dot(&now, &before) < least * (size(&now) * size(&before)).sqrt()).then_some(joint)
        })
    }

    /// Lets `dt` `[s]` pass.
    pub(crate) fn advance(&mut self, dt: f32) {
        let Some(left) = &mut self.left else { return };
        if *left <= 0.0 {
            self.left = None;
            return;
        }
        *left = (*left - (dt - self.waits).max(0.0)).max(0.0);
        self.waits = (self.waits - dt).max(0.0);
    }

    /// Writes the skinning matrices that the cloth is given. What is flat is where it is.
    pub(crate) fn pose(&self, skin: &Skin, joints: &mut Vec<Affine3A>) {
        joints.clone_from(&self.live);
        let Some(left) = self.left.filter(|left| *left > 0.0) else { return };
        let done = 1.0 - left / RESPONSE_TIME;
        let share = done * done * (3.0 - 2.0 * done);
        for (&(joint, above), from) in self.hierarchy.iter().zip(&self.from) {
            let Some(above) = above else { continue };
            let at = |joint: u16| self.live[usize::from(joint)] * skin.bind(joint);
            let to = local(at(above), at(joint));
            let seen = Transform {
                translation: from.translation.lerp(to.translation, share),
                rotation: from.rotation.slerp(to.rotation, share),
                scale: from.scale.lerp(to.scale, share),
            };
            let place = joints[usize::from(above)] * skin.bind(above) * seen.compute_affine() * skin.bind(joint).inverse();
            if place.is_finite() {
                joints[usize::from(joint)] = place;
            }
        }
    }

    /// Where the cloth sees a body that hangs on a joint of the skin, at the start of the frame and at its end. `joints`: the
    /// skinning matrices that the cloth was given then.
    pub(crate) fn carry(&self, joint: u16, joints: [&[Affine3A]; 2], body: [Pose; 2]) -> Option<[Pose; 2]> {
        let at = usize::from(joint);
        let place = |to: &[Affine3A], from: &[Affine3A], body: Pose| {
            let motion = *to.get(at)? * from.get(at)?.inverse();
            let (_, rotation, translation) = motion.to_scale_rotation_translation();
            motion.is_finite().then(|| Pose::from_parts(translation, rotation) * body)
        };
        Some([place(joints[0], &self.live_before, body[0])?, place(joints[1], &self.live, body[1])?])
    }
}

/// A joint as the one above sees it.
fn local(above: Affine3A, joint: Affine3A) -> Transform {
    transform(above.inverse() * joint)
}

/// Not finite where a scale is 0.
fn transform(affine: Affine3A) -> Transform {
    if affine.is_finite() && affine.matrix3.determinant() != 0.0 {
        Transform::from_matrix(Mat4::from(affine))
    } else {
        Transform::from_translation(Vec3::NAN)
    }
}

/// Of two matrices, as of two vectors of nine numbers.
fn dot(a: &Mat3A, b: &Mat3A) -> f32 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

/// Joints of a skin and the nearest above them, from the roots down.
fn hierarchy(skin: &Skin, parents: &Query<&ChildOf>) -> Vec<(u16, Option<u16>)> {
    let joints: Vec<Entity> = skin.entities().collect();
    let above = joints_above(&joints, |entity| parents.get(entity).ok().map(ChildOf::parent));
    let above: Vec<Option<u16>> = above.into_iter().map(|joint| joint.and_then(|joint| u16::try_from(joint).ok())).collect();
    let depth = |joint: u16| core::iter::successors(above[usize::from(joint)], |&up| above[usize::from(up)]).count();
    let mut hierarchy: Vec<(u16, Option<u16>)> = (0..).zip(above.iter().copied()).collect();
    hierarchy.sort_by_key(|(joint, _)| depth(*joint));
    hierarchy
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::ecs::system::SystemState;
    use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};

    use super::*;
    use crate::bind::read;
    use crate::solver::rest::{RestShape, SourceMesh};

    /// A triangle on a chain of three joints at heights of 0, 1 and 2 m, in an order of their own, and the joints.
    fn chain(world: &mut World) -> (Skin, [Entity; 3]) {
        let root = world.spawn_empty().id();
        let middle = world.spawn(ChildOf(root)).id();
        // A joint that the skin does not know.
        let between = world.spawn(ChildOf(middle)).id();
        let tip = world.spawn(ChildOf(between)).id();
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 1.0]])
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(vec![[0, 1, 2, 0]; 3]))
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.2, 0.3, 0.5, 0.0]; 3])
            .with_inserted_indices(Indices::U32(vec![0, 1, 2]));
        let authored = read(&mesh).expect("a mesh");
        let source = SourceMesh { positions: authored.positions.clone(), triangles: vec![[0, 1, 2]], ..Default::default() };
        let (rest, _) = RestShape::build(&source).expect("a shape");
        let joints = [(root, 0.0), (tip, 2.0), (middle, 1.0)];
        let joints = joints.map(|(joint, height)| (joint, Affine3A::from_translation(Vec3::NEG_Y * height))).to_vec();
        (Skin::new(&mesh, &authored, &rest, joints).expect("a skin"), [root, middle, tip])
    }

    /// Skinning matrices of the chain, whose root lies at `at` and whose other joints are bent by `angle` each.
    fn bent(at: Vec3, angle: f32) -> [Affine3A; 3] {
        let bend = Affine3A::from_rotation_translation(Quat::from_rotation_z(angle), Vec3::Y);
        let root = Affine3A::from_translation(at);
        let [middle, tip] = [root * bend, root * bend * bend];
        [root, tip * Affine3A::from_translation(Vec3::NEG_Y * 2.0), middle * Affine3A::from_translation(Vec3::NEG_Y)]
    }

    /// Steps a cross-fade from the bind pose to a bend by 1.2 in frames of `dt` `[s]`; calls `each` with what the cloth is
    /// given.
    fn fade(dt: f32, mut each: impl FnMut(&Crossfade, &[Affine3A])) {
        let mut world = World::new();
        let (skin, _) = chain(&mut world);
        let mut parents = SystemState::<Query<&ChildOf>>::new(&mut world);
        let mut crossfade = Crossfade::of(&bent(Vec3::X, 1.2));
        crossfade.begin_in_bind_pose(&skin, true, None, &parents.get(&world).expect("a query"));
        let mut joints = Vec::new();
        for _ in 0..(0.6 / dt) as u32 {
            crossfade.advance(dt);
            crossfade.pose(&skin, &mut joints);
            each(&crossfade, &joints);
        }
    }

    #[test]
    fn a_skeleton_waits_in_its_bind_pose_and_goes_to_the_one_that_is_there() {
        let mut angles = Vec::new();
        fade(1.0 / 60.0, |crossfade, joints| {
            let [middle, tip] =
                [joints[2] * Affine3A::from_translation(Vec3::Y), joints[1] * Affine3A::from_translation(Vec3::Y * 2.0)];
            assert_eq!(joints[0].translation, Vec3A::X, "the root is where it is");
            assert!((middle.translation.distance(Vec3A::X) - 1.0).abs() < 1.0e-4, "bones keep their length");
            assert!((tip.translation.distance(middle.translation) - 1.0).abs() < 1.0e-4, "bones keep their length");
            angles.push(transform(middle).rotation.angle_between(Quat::IDENTITY));
            assert!(crossfade.is_active() || joints == crossfade.live());
        });
        assert!(angles[13] < 1.0e-3, "it waits for a quarter of a second: {angles:?}");
        assert!((angles[21] - 0.6).abs() < 0.15, "then it is half way after half as long: {angles:?}");
        assert!(angles[30] > 1.199, "and there after as long: {angles:?}");
        assert!(angles.windows(2).all(|pair| pair[1] > pair[0] - 1.0e-3), "{angles:?}");
    }

    #[test]
    fn what_hangs_on_a_joint_is_where_the_cloth_is_given_that() {
        let mut before = Vec::new();
        fade(1.0 / 60.0, |crossfade, joints| {
            if !before.is_empty() {
                let body = Pose::from_parts(Vec3::new(3.0, 1.0, 0.5), Quat::from_rotation_x(0.3));
                let [from, to] = crossfade.carry(1, [&before, joints], [body; 2]).expect("a body");
                let fixed = |joints: &[Affine3A], pose: Pose| joints[1].inverse().transform_point3(pose.translation);
                let there = fixed(crossfade.live(), body);
                assert!(fixed(joints, to).distance(there) < 1.0e-4 && fixed(&before, from).distance(there) < 1.0e-4);
            }
            before = joints.to_vec();
        });
    }

    #[test]
    fn a_bone_that_turns_faster_than_any_clip_jumped() {
        let mut world = World::new();
        let (skin, _) = chain(&mut world);
        let mut parents = SystemState::<Query<&ChildOf>>::new(&mut world);
        let mut jump_of = |matters: u16, angle: f32, dt: f32| {
            // Both bends: the tip turns twice as far. The root goes anywhere.
            let (before, live) = (bent(Vec3::ZERO, 0.1).to_vec(), bent(Vec3::ONE, 0.1 + 0.5 * angle).to_vec());
            let mut crossfade = Crossfade { live, live_before: before.clone(), ..default() };
            let spin = 10.0 * core::f32::consts::PI;
            let parents = parents.get(&world).expect("a query");
            crossfade.begin_after_jump(&skin, &before, (spin, dt), |joint| joint == matters, &parents);
            crossfade.is_active()
        };
        let degrees = f32::to_radians;
        assert!(jump_of(1, 1.0, 0.01) && !jump_of(0, 1.0, 0.01), "one of which nothing hangs");
        let mut jumps = |angle: f32, dt: f32| jump_of(1, angle, dt);
        assert!(!jumps(degrees(29.0), 1.0 / 60.0) && jumps(degrees(31.0), 1.0 / 60.0));
        assert!(!jumps(degrees(59.0), 1.0 / 30.0) && jumps(degrees(61.0), 1.0 / 30.0));
        assert!(!jumps(degrees(29.0), 1.0 / 144.0) && jumps(degrees(31.0), 1.0 / 144.0));
        assert!(!jumps(degrees(170.0), 0.1), "a long frame may turn anything");
    }

    #[test]
    fn what_is_flat_is_where_it_is() {
        let mut world = World::new();
        let (skin, _) = chain(&mut world);
        let mut parents = SystemState::<Query<&ChildOf>>::new(&mut world);
        let mut live = bent(Vec3::X, 1.2);
        live[2] *= Affine3A::from_scale(Vec3::ZERO);
        let mut crossfade = Crossfade::of(&live);
        crossfade.begin_in_bind_pose(&skin, true, None, &parents.get(&world).expect("a query"));
        let mut joints = Vec::new();
        for _ in 0..40 {
            crossfade.advance(1.0 / 60.0);
            crossfade.pose(&skin, &mut joints);
            assert!(joints.iter().all(Affine3A::is_finite), "{joints:?}");
        }
        assert_eq!(joints, live);
    }
}
