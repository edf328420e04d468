//! Resolve: takes crossing cloths apart.

use bevy::prelude::*;

use super::islands::{Cloths, is_awake, run};
use crate::islands::ClothIslands;
use crate::solver::island::Stage;
use crate::time::ClothTime;

/// Untangles.
pub(crate) fn resolve(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>, mut cloths: Cloths) {
    let _span = debug_span!("cloth/resolve").entered();
    run(&mut islands, &mut cloths, Stage::Resolve, time.delta_secs(), is_awake);
}
