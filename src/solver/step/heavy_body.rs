//! Substeps for heavier bodies that lie on the cloth.

use glam::Vec3;

use super::count::MOST_FOR_BODIES;
use super::{Memory, Stepped};
use crate::solver::scales::ALIGNED;

impl Stepped<'_> {
    /// Finds the factor of substeps for heavier bodies that lie on the cloth. A body that presses the cloth too far multiplies
    /// them by √(mass of the body / mass of the cloth), until it leaves. A factor that its speed asked for stays as long. The
    /// depth does not count: more substeps in cloth that is drawn out already throw it up. A body that the cloth rests on is
    /// left out.
    pub(super) fn count_for_heavy_bodies(&self, memory: &mut Memory) {
        let (own, bound) = (self.mass(memory), self.most_pressed());
        let mut for_heavy_body = 1;
        for (index, body) in self.input.bodies.iter().enumerate() {
            let mass = body.rigid.map_or(f32::INFINITY, |slot| memory.coupling.mass(slot));
            let heavier = mass / own;
            if !(heavier > 1.0 && mass.is_finite()) {
                continue;
            }
            let pushes = memory.touches().filter(|(body, ..)| *body == index);
            let (push, count) = pushes.fold((0.0, 0.0), |(push, count), (_, _, load)| (push + load, count + 1.0));
            if count > 0.0 || memory.contacts.is_near(index) {
                for_heavy_body = for_heavy_body.max(memory.for_heavy_body);
            }
            let given = body.rigid.map_or(Vec3::ZERO, |slot| memory.coupling.given(slot).linear);
            let lies_on_it = given.dot(self.input.gravity) > ALIGNED * given.length() * self.input.gravity.length();
            if push > bound * count && !lies_on_it {
                for_heavy_body = for_heavy_body.max(heavier.sqrt().min(MOST_FOR_BODIES).ceil() as u32);
            }
        }
        memory.for_heavy_body = for_heavy_body;
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use parry3d::math::Pose;

    use super::super::factors::Factors;
    use super::*;
    use crate::solver::anchors::Anchors;
    use crate::solver::body::{Approach, Body, BodyContext, Projection, Touch, shape};
    use crate::solver::couple::Rigid;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{GRAVITY, grid};
    use crate::solver::settings::Fabric;
    use crate::solver::step::FrameInput;
    use crate::solver::wind::Wind;

    /// A body of so many times the mass of the cloth, and what it does.
    struct Case {
        what: &'static str,
        /// Infinite: cloth cannot move it.
        heavier: f32,
        /// How far it presses, in what one may press `[1]`.
        pressed: f32,
        /// Whether it is above the cloth; else the cloth rests on it.
        above: bool,
        /// The factor of the frame before, and that of the next.
        factors: [u32; 2],
    }

    const LEAVES: f32 = -1.0;

    #[test]
    fn bodies_that_press_too_far_and_are_heavier_take_more_substeps_until_they_leave() {
        let case = |what, heavier, pressed, above, factors| Case { what, heavier, pressed, above, factors };
        for case in [
            case("it presses too far", 10.0, 1.5, true, [1, 4]),
            case("no more than eight times", 1000.0, 1.5, true, [1, 8]),
            case("its depth does not count", 10.0, 3.0, true, [1, 4]),
            case("it is lighter", 0.9, 1.5, true, [1, 1]),
            case("cloth cannot move it", f32::INFINITY, 1.5, true, [1, 1]),
            case("it does not press too far", 10.0, 0.5, true, [1, 1]),
            case("as long as it touches", 10.0, 0.5, true, [3, 3]),
            case("by more than before", 10.0, 1.5, true, [3, 4]),
            case("by less than before", 10.0, 1.5, true, [6, 6]),
            case("it is near", 10.0, 0.0, true, [3, 3]),
            case("it has left", 10.0, LEAVES, true, [3, 1]),
            case("what is lighter does not keep it", 0.9, 1.5, true, [3, 1]),
            case("the cloth rests on it", 10.0, 1.5, false, [1, 1]),
        ] {
            let factor = next_factor(&case);
            assert_eq!(factor, case.factors[1], "{}: {} times heavier, {}", case.what, case.heavier, case.pressed);
        }
    }

    fn next_factor(case: &Case) -> u32 {
        let (rest, _) = RestShape::build(&grid(5, 5, |u, v| vec3(u - 0.5, 0.0, v - 0.5))).expect("a sheet");
        let fabric = Fabric::default();
        let factors = Factors { area: 1.0, ..Factors::default() };
        let mut memory = Memory { factors, for_heavy_body: case.factors[0], ..Memory::default() };
        let inverse_mass = Vec3::splat((case.heavier * fabric.density).recip());
        let slot = memory.coupling.add(Rigid { inverse_mass, ..Rigid::immovable(Vec3::ZERO, Vec3::ZERO) });
        // A plate that goes through the place of the cloth.
        let (half, off) = (0.1, 0.1 + fabric.thickness);
        let plate = shape::cuboid(Vec3::new(2.0, half, 2.0)).expect("a plate");
        let side = if case.above { Vec3::Y } else { Vec3::NEG_Y };
        let at = |gap: f32| Pose::from_translation((off + gap) * side);
        let mut bodies = [Body { rigid: Some(slot), ..Body::at_rest(plate, at(0.0)) }];
        let anchors = Anchors::default();
        let wind = Wind::NONE;
        let input = FrameInput { dt: 0.01, gravity: GRAVITY, bodies: &[], wind: &wind, skinned: None };
        let cloth = Stepped { rest: &rest, fabric: &fabric, anchors: &anchors, input };
        let pressed = case.pressed * cloth.most_pressed();
        let gap = if case.pressed == LEAVES { 1.0 } else { 1.0e-5 };
        (bodies[0].from, bodies[0].to) = (at(gap), at(gap - pressed.max(0.0)));
        let mut positions: Vec<_> = rest.positions.iter().map(|x| x.extend(25.0 / fabric.density)).collect();
        let mut previous = positions.clone();
        let approach = Approach { dt: 0.01, substep: 0.01, gravity: GRAVITY, thickness: fabric.thickness, extra: 0.0 };
        memory.contacts.gather(&bodies, &positions, &previous, &approach);
        let Memory { contacts, coupling, .. } = &mut memory;
        let mut context = BodyContext { bodies: &bodies, span: (0.0, 1.0), touch: Touch::frictionless(&fabric), coupling };
        contacts.project(&mut context, &mut positions, &mut previous, &[], Projection::First);
        Stepped { input: FrameInput { bodies: &bodies, ..input }, ..cloth }.count_for_heavy_bodies(&mut memory);
        memory.for_heavy_body
    }
}
