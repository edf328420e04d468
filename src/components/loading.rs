//! What is done about large meshes when they become cloth.

use bevy::prelude::*;

/// Loading: how large a mesh may be to become cloth at once, as a resource.
///
/// To make a rest shape of a mesh takes some 5 ms for each thousand vertices, once for all cloths with this mesh and scale. A
/// mesh that is larger is prepared on Bevy's `AsyncComputeTaskPool`, so that no frame waits for that. Meanwhile the authored
/// mesh is shown, and the status of the cloth is [`ClothWaitingFor::Build`](crate::ClothWaitingFor). A cloth that is simulated
/// and gets another mesh or scale is prepared at once. Without threads, as on the web, the pool works between frames.
///
/// In which frame such a cloth begins depends on the machine. Where that matters, in lockstep or in tests, prepare all at once:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn add(app: &mut App) {
/// app.insert_resource(ClothLoading::AT_ONCE);
/// # }
/// ```
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothLoading {
    /// Vertices from which on a mesh is prepared in the background (count). Default 1000, any value. Larger: frames wait for
    /// the mesh; smaller: small cloths begin a frame or two later. With a [`ClothBudget`](crate::ClothBudget), also particles
    /// from which on cloth is stepped there that does not fit.
    pub in_background_from: u32,
}

impl ClothLoading {
    /// No mesh is prepared in the background.
    pub const AT_ONCE: Self = Self { in_background_from: u32::MAX };
}

impl Default for ClothLoading {
    fn default() -> Self {
        Self { in_background_from: 1000 }
    }
}
