//! Who touches a cloth, for those who ask.

use bevy::prelude::*;

use super::checked::Checked;

/// Asks for [`ClothContactStarted`] and [`ClothContactEnded`] on this cloth, and for [`ClothContacts`], the list of what
/// touches it. Without it nothing is computed.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(ClothContacts)]
pub struct ClothContactEvents {
    /// Time without touch after which a contact has ended `[s]`. Default 0.1, range 0 to 10. 0: cloth that bounces or flutters
    /// tells of every touch.
    pub patience: f32,
}

impl Default for ClothContactEvents {
    fn default() -> Self {
        Self { patience: 0.1 }
    }
}

impl ClothContactEvents {
    pub(crate) fn patience(&self, checked: &mut Checked) -> f32 {
        checked.within("contact_events.patience", self.patience, 0.1, 0.0, 10.0)
    }
}

/// Bodies and cloths that touch a cloth with [`ClothContactEvents`], which inserts and removes this component. Read it after
/// [`ClothSystems::Respond`](crate::ClothSystems::Respond); written by the simulation and not saved.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn touched(cloths: Query<(Entity, &ClothContacts)>) {
///     for (cloth, contacts) in &cloths {
///         for touch in &contacts.touches {
///             info!("{cloth} touches {}", touch.other);
///         }
///     }
/// }
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothContacts {
    /// Bodies and other cloths, in the order of entities, each as of the last frame in which it touched.
    #[cfg_attr(feature = "serialize", serde(skip))]
    #[reflect(ignore)]
    pub touches: Vec<ClothTouch>,
}

/// A body or another cloth that touches a cloth.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub struct ClothTouch {
    /// The body or cloth.
    pub other: Entity,
    /// Particles that touch the body, or pairs of primitives of the two cloths.
    pub contacts: u32,
    /// Where the largest impulse acts, in the world `[m]`.
    pub point: Vec3,
    /// Unit normal there, towards this cloth; zero where it has no direction.
    pub normal: Vec3,
    /// Largest impulse of one contact over the frame `[N·s]`, from the mean push of its substeps.
    pub impulse: f32,
    /// Time since it last touched `[s]`.
    pub since: f32,
}

/// A body or another cloth has begun to touch a cloth with [`ClothContactEvents`].
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothContactStarted {
    /// The cloth.
    pub entity: Entity,
    /// The body or cloth, and how they touch.
    pub touch: ClothTouch,
}

/// A body or another cloth no longer touches a cloth with [`ClothContactEvents`]; it may be gone, as the cloth may. It comes
/// for all that touched when a cloth is [disabled](crate::ClothDisabled), fails, or loses `Cloth` or `ClothContactEvents`.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothContactEnded {
    /// The cloth.
    pub entity: Entity,
    /// The body or cloth.
    pub other: Entity,
}
