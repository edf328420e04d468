//! The mouse as a hand that drags cloth.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use super::{PointerTaken, orbit};

/// Lets the mouse drag what is [`ClothDraggable`].
pub fn plugin(app: &mut App) {
    app.add_plugins(ClothPickingPlugin).add_systems(Update, stay.before(orbit::turn).run_if(any_with_component::<Window>));
}

/// While a cloth is held the camera does not turn.
fn stay(grips: Query<(), With<ClothGrab>>, mut taken: ResMut<PointerTaken>) {
    taken.0 = !grips.is_empty();
}
