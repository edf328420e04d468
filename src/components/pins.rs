//! Where a cloth is held.

use std::sync::Arc;

use bevy::ecs::entity::MapEntities;
use bevy::prelude::*;

use super::checked::Checked;

/// Where a cloth is held, and by what.
///
/// It is a list of sets, each with its own weight and target. Pinned vertices keep their place relative to the target: the
/// cloth's own entity unless [`ClothPins::to`] names another, or the skin when the mesh is skinned.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn pins(left_hand: Entity) -> ClothPins {
/// ClothPins::vertices([0, 40]).to(left_hand).and(ClothPins::color(ClothColorChannel::R).weighted(0.5))
/// # }
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPins {
    /// The sets. Where two hold one vertex, the heavier weight holds it; with equal weights the first.
    #[entities]
    pub sets: Vec<ClothPinSet>,
    /// What happens when the target of a set is despawned. Default [`ClothOnTargetLost::Hold`].
    pub on_target_lost: ClothOnTargetLost,
}

/// Vertices that are held by one target.
#[derive(Clone, Debug, PartialEq, Reflect, MapEntities)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPinSet {
    /// Which vertices.
    pub select: ClothPinSelect,
    /// How firmly: 1 = rigidly, 0 = not at all (dimensionless). Default 1, range 0 to 1. Multiplies the weights of the
    /// selection.
    pub weight: f32,
    /// The entity that holds them; the cloth's own if `None`. Default `None`.
    #[entities]
    pub target: Option<Entity>,
}

/// Which vertices of the mesh a set holds.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothPinSelect {
    /// Vertices of the mesh by index. Indices past the end are ignored and listed in
    /// [`ClothBuildReport::bad_pins`](crate::ClothBuildReport::bad_pins).
    Vertices(Vec<u32>),
    /// Vertices of the mesh by index, each with a weight from 0 (free) to 1 (held). Weights outside count as 0 or 1; NaN holds
    /// nothing.
    Weighted(Vec<(u32, f32)>),
    /// Vertices at whose position, in the space of the mesh `[m]`, the predicate holds.
    ///
    /// A function cannot be written to a file: serializing pins or a scene that hold one is an error. Name the vertices, a
    /// colour channel or an attribute instead where scenes are saved.
    #[cfg_attr(feature = "serialize", serde(skip))]
    Position(PositionPredicate),
    /// A channel of the vertex colour is the weight.
    Color(ClothColorChannel),
    /// A float attribute of that name is the weight, such as `"_PIN"` in a glTF. An attribute of several components gives the
    /// first, or the one named behind a dot: `"_CLOTH_PAINT.r"`.
    Attribute(String),
}

/// A channel of the vertex colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothColorChannel {
    /// Red.
    #[default]
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// A test on positions.
#[derive(Clone, Reflect)]
#[reflect(opaque)]
#[reflect(Clone, Debug, PartialEq)]
pub struct PositionPredicate(Arc<dyn Fn(Vec3) -> bool + Send + Sync>);

impl PositionPredicate {
    /// Wraps a function of the position in the space of the mesh `[m]`.
    pub fn new(predicate: impl Fn(Vec3) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(predicate))
    }

    /// Whether it holds at `position` `[m]`.
    #[must_use]
    pub fn holds(&self, position: Vec3) -> bool {
        (self.0)(position)
    }
}

impl core::fmt::Debug for PositionPredicate {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("PositionPredicate(..)")
    }
}

/// Equal when they are the same function object.
impl PartialEq for PositionPredicate {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// What happens when the target of a pin set is despawned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothOnTargetLost {
    /// The set stays where it is.
    #[default]
    Hold,
    /// The set falls.
    Release,
    /// The cloth is despawned.
    Despawn,
}

/// No vertex at all.
impl Default for ClothPinSelect {
    fn default() -> Self {
        Self::Vertices(Vec::new())
    }
}

impl Default for ClothPinSet {
    fn default() -> Self {
        ClothPinSelect::default().into()
    }
}

impl From<ClothPinSelect> for ClothPinSet {
    fn from(select: ClothPinSelect) -> Self {
        Self { select, weight: 1.0, target: None }
    }
}

impl From<ClothPinSelect> for ClothPins {
    fn from(select: ClothPinSelect) -> Self {
        Self { sets: vec![select.into()], on_target_lost: ClothOnTargetLost::Hold }
    }
}

impl ClothPins {
    /// Names a weight that is out of range: it is used clamped, and holds nothing if it is not a number.
    pub(crate) fn checked(&self, checked: &mut Checked) {
        if let Some(bad) = self.sets.iter().find(|set| !(0.0..=1.0).contains(&set.weight)) {
            checked.within("ClothPinSet::weight", bad.weight, 0.0, 0.0, 1.0);
        }
    }

    /// No pins.
    pub const NONE: Self = Self { sets: Vec::new(), on_target_lost: ClothOnTargetLost::Hold };

    /// Holds vertices of the mesh by index.
    #[must_use]
    pub fn vertices(indices: impl IntoIterator<Item = u32>) -> Self {
        ClothPinSelect::Vertices(indices.into_iter().collect()).into()
    }

    /// Holds vertices of the mesh by index, each with a weight from 0 to 1.
    #[must_use]
    pub fn weights(weights: impl IntoIterator<Item = (u32, f32)>) -> Self {
        ClothPinSelect::Weighted(weights.into_iter().collect()).into()
    }

    /// Holds the vertices at whose position in the space of the mesh `[m]` the predicate holds. Cannot be serialized: see
    /// [`ClothPinSelect::Position`].
    #[must_use]
    pub fn where_position(predicate: impl Fn(Vec3) -> bool + Send + Sync + 'static) -> Self {
        ClothPinSelect::Position(PositionPredicate::new(predicate)).into()
    }

    /// Holds vertices by a channel of the vertex colour: 1 = rigidly, 0 = not at all.
    #[must_use]
    pub fn color(channel: ClothColorChannel) -> Self {
        ClothPinSelect::Color(channel).into()
    }

    /// Holds vertices by a float attribute of the mesh: 1 = rigidly, 0 = not at all.
    #[must_use]
    pub fn attribute(name: impl Into<String>) -> Self {
        ClothPinSelect::Attribute(name.into()).into()
    }

    /// Hands the last set to another entity.
    #[must_use]
    pub fn to(mut self, target: Entity) -> Self {
        if let Some(set) = self.sets.last_mut() {
            set.target = Some(target);
        }
        self
    }

    /// How firmly the last set holds, from 0 to 1.
    #[must_use]
    pub fn weighted(mut self, weight: f32) -> Self {
        if let Some(set) = self.sets.last_mut() {
            set.weight = weight;
        }
        self
    }

    /// Adds the sets of another.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.sets.extend(other.sets);
        self
    }

    /// What happens when the target of a set is despawned.
    #[must_use]
    pub fn on_target_lost(mut self, reaction: ClothOnTargetLost) -> Self {
        self.on_target_lost = reaction;
        self
    }
}
