//! What settings belong to, in the order and under the headings of the panel.

/// What a setting belongs to: a component of a cloth, or a resource of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// [`ClothMaterial`](crate::ClothMaterial).
    Material,
    /// [`ClothSolver`](crate::ClothSolver).
    Solver,
    /// [`ClothCollision`](crate::ClothCollision).
    Collision,
    /// [`ClothUntangling`](crate::ClothUntangling).
    Untangle,
    /// [`ClothSkipFrame`](crate::ClothSkipFrame).
    Skip,
    /// [`ClothSleep`](crate::ClothSleep).
    Sleep,
    /// [`ClothLimits`](crate::ClothLimits).
    Limits,
    /// [`ClothDrive`](crate::ClothDrive).
    Drive,
    /// [`ClothBlend`](crate::ClothBlend).
    Blend,
    /// [`ClothInertia`](crate::ClothInertia).
    Inertia,
    /// [`ClothBody`](crate::ClothBody), of the character that wears it.
    Body,
    /// [`ClothLod`](crate::ClothLod).
    Lod,
    /// [`ClothPriority`](crate::ClothPriority).
    Priority,
    /// [`ClothWind`](crate::ClothWind).
    OwnWind,
    /// [`ClothPins`](crate::ClothPins).
    Pins,
    /// [`ClothGlobalWind`](crate::ClothGlobalWind).
    Wind,
    /// [`ClothGravity`](crate::ClothGravity).
    Gravity,
    /// [`ClothBudget`](crate::ClothBudget).
    Budget,
}

impl Part {
    /// All parts, in the order of the panel.
    pub const ALL: [Self; 18] = [
        Self::Material,
        Self::Solver,
        Self::Collision,
        Self::Untangle,
        Self::Skip,
        Self::Sleep,
        Self::Limits,
        Self::Drive,
        Self::Blend,
        Self::Inertia,
        Self::Body,
        Self::Lod,
        Self::Priority,
        Self::OwnWind,
        Self::Pins,
        Self::Wind,
        Self::Gravity,
        Self::Budget,
    ];

    /// What comes before the names of its settings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::Solver => "solver",
            Self::Collision => "collision",
            Self::Untangle => "untangle",
            Self::Skip => "skip",
            Self::Sleep => "sleep",
            Self::Limits => "limits",
            Self::Drive => "drive",
            Self::Blend => "blend",
            Self::Inertia => "inertia",
            Self::Body => "body",
            Self::Lod => "lod",
            Self::OwnWind => "own wind",
            Self::Pins => "pins",
            Self::Wind => "wind",
            Self::Gravity => "gravity",
            Self::Priority | Self::Budget => "budget",
        }
    }

    /// Heading of its section.
    #[must_use]
    pub const fn heading(self) -> &'static str {
        match self {
            Self::Material => "Material",
            Self::Solver => "Solver",
            Self::Collision => "Collision",
            Self::Untangle => "Untangling",
            Self::Skip => "Shown while tangled",
            Self::Sleep => "Sleep at rest",
            Self::Limits => "Distance from the skin",
            Self::Drive => "Drive to the skin",
            Self::Blend => "Simulation and animation",
            Self::Inertia => "Inertia",
            Self::Body => "Body of the character",
            Self::Lod => "Level of detail",
            Self::Priority => "Priority",
            Self::OwnWind => "Wind at this cloth",
            Self::Pins => "Pins",
            Self::Wind => "Wind in the world",
            Self::Gravity => "Gravity in the world",
            Self::Budget => "Budget of the world",
        }
    }
}
