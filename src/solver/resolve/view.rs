//! What an iteration looks at.

use glam::Vec4;

use crate::solver::detect::{Crossing, Surface};

/// What an iteration looks at.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub surface: &'a Surface,
    pub crossings: &'a [Crossing],
    pub positions: &'a [Vec4],
}
