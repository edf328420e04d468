//! Resolve: takes crossing cloths apart.

use bevy::prelude::*;

use super::islands::{Cloths, is_awake, run};
use crate::islands::ClothIslands;
use crate::time::ClothTime;

/// Untangles.
pub(crate) fn resolve(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>, mut cloths: Cloths) {
    let _span = debug_span!("cloth/resolve").entered();
    let dt = time.delta_secs();
    run(&mut islands, &mut cloths, 1, dt, is_awake, |island, cloths| island.solver.resolve(dt, island.settings, cloths));
}
