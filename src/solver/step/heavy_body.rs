//! Substeps for heavier bodies that lie on the cloth.

use glam::Vec3;

use super::count::MOST_FOR_BODIES;
use super::{Scratch, Stepped};
use crate::solver::scales::ALIGNED;

impl Stepped<'_> {
    /// Finds the factor of substeps for heavier bodies that lie on the cloth. A body that presses the cloth too far multiplies
    /// them by √(mass of the body / mass of the cloth), until it leaves. A factor that its speed asked for stays as long. The
    /// depth does not count: more substeps in cloth that is drawn out already throw it up. A body that the cloth rests on is
    /// left out.
    pub(super) fn count_for_heavy_bodies(&self, scratch: &mut Scratch) {
        let (own, bound) = (self.mass(scratch), self.most_pressed());
        let mut for_heavy_body = 1;
        for (index, body) in self.input.bodies.iter().enumerate() {
            let mass = body.rigid.map_or(f32::INFINITY, |slot| scratch.coupling.mass(slot));
            let heavier = mass / own;
            if !(heavier > 1.0 && mass.is_finite()) {
                continue;
            }
            let pushes = scratch.touches().filter(|(body, ..)| *body == index);
            let (push, count) = pushes.fold((0.0, 0.0), |(push, count), (_, _, load)| (push + load, count + 1.0));
            if count > 0.0 || scratch.contacts.is_near(index) {
                for_heavy_body = for_heavy_body.max(scratch.for_heavy_body);
            }
            let given = body.rigid.map_or(Vec3::ZERO, |slot| scratch.coupling.given(slot).linear);
            let lies_on_it = given.dot(self.input.gravity) > ALIGNED * given.length() * self.input.gravity.length();
            if push > bound * count && !lies_on_it {
                for_heavy_body = for_heavy_body.max(heavier.sqrt().min(MOST_FOR_BODIES).ceil() as u32);
            }
        }
        scratch.for_heavy_body = for_heavy_body;
    }
}
