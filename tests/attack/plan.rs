//! What is done to an app, frame by frame, as data: made from a seed up front, so that any part of it can be left out.

use fastrand::Rng;

use super::wild::once_in;

/// Entities that have a number of their own; what is done names them by it.
pub const SLOTS: usize = 12;

/// What is done. A seed goes with it for everything it has to choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Spawns a cloth with a sheet for a mesh.
    Cloth,
    /// Spawns a cloth with any mesh.
    Strange,
    /// Spawns two cloths through each other.
    Tangle,
    /// Spawns a cloth on a skin.
    Skinned,
    /// Spawns a skinned body that colliders are fitted to.
    Character,
    /// Spawns a collider.
    Body,
    /// Spawns a wind zone, a grip, a camera, or an empty place.
    Thing,
    /// Despawns an entity.
    Despawn,
    /// Another mesh, none, or other numbers in the mesh that it has.
    Swap,
    /// Disables or enables.
    Disable,
    /// Clones an entity.
    Clone,
    /// Another parent, or none.
    Reparent,
    /// Moves it a little, or far.
    Move,
    /// Moves and turns it as a dancer, a joint too.
    Dance,
    /// Another scale.
    Scale,
    /// A transform with numbers that are none.
    Nowhere,
    /// Puts a component in.
    Put,
    /// Takes a component out.
    Take,
    /// Changes a component that is there.
    Poke,
    /// Another way to untangle.
    Method,
    /// Gravity, wind or budget.
    World,
    /// Other frames: longer, shorter, none, slow motion, pause.
    Clock,
    /// A number in the state of the solver.
    State,
    /// An impulse, or an explosion.
    Kick,
    /// Questions.
    Ask,
    /// Takes a snapshot, or goes back to one.
    Snapshot,
    /// Takes out every component.
    Bare,
    /// Despawns everything.
    Clear,
}

/// How often each is done, in proportion.
const OFTEN: [(Action, u32); 28] = [
    (Action::Cloth, 12),
    (Action::Strange, 4),
    (Action::Tangle, 3),
    (Action::Skinned, 5),
    (Action::Character, 2),
    (Action::Body, 8),
    (Action::Thing, 5),
    (Action::Despawn, 5),
    (Action::Swap, 5),
    (Action::Disable, 5),
    (Action::Clone, 3),
    (Action::Reparent, 4),
    (Action::Move, 8),
    (Action::Dance, 8),
    (Action::Scale, 3),
    (Action::Nowhere, 2),
    (Action::Put, 10),
    (Action::Take, 6),
    (Action::Poke, 10),
    (Action::Method, 3),
    (Action::World, 3),
    (Action::Clock, 4),
    (Action::State, 3),
    (Action::Kick, 3),
    (Action::Ask, 3),
    (Action::Snapshot, 4),
    (Action::Bare, 1),
    (Action::Clear, 1),
];

/// An action, when it is done, and to what.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Before this frame.
    pub frame: u32,
    /// What.
    pub action: Action,
    /// To the entity of this number.
    pub slot: usize,
    /// With another.
    pub other: usize,
    /// What it chooses from.
    pub seed: u64,
}

/// How the app is made.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Whether cloth runs in the fixed schedule.
    pub fixed: bool,
    /// Whether everything is drawn as gizmos.
    pub draws: bool,
    /// Whether stages are measured.
    pub measures: bool,
    /// Whether avian moves bodies, too.
    pub physics: bool,
}

/// An app and what is done to it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the app is made.
    pub setup: Setup,
    /// In the order of frames.
    pub steps: Vec<Step>,
    /// Frames.
    pub frames: u32,
}

impl Plan {
    /// Of an app: several entities at first, then something every few frames.
    pub fn app(seed: u64, frames: u32) -> Self {
        let mut rng = Rng::with_seed(seed);
        let setup = Setup {
            fixed: once_in(&mut rng, 4),
            draws: once_in(&mut rng, 6),
            measures: once_in(&mut rng, 4),
            physics: seed % 8 == 5,
        };
        let total: u32 = OFTEN.iter().map(|(_, often)| often).sum();
        // From three in a frame to one in eight frames.
        let (busy, at_once) = if once_in(&mut rng, 6) { (1, 3) } else { (rng.u32(1..9), 1) };
        let mut steps = Vec::new();
        for frame in 0..frames {
            let count = if frame == 0 { 4 } else { at_once * u32::from(once_in(&mut rng, busy)) };
            for _ in 0..count {
                let mut left = rng.u32(0..total);
                let often = OFTEN.iter().find(|(_, often)| {
                    let found = left < *often;
                    left = left.saturating_sub(*often);
                    found
                });
                let (slot, other) = (rng.usize(0..SLOTS), rng.usize(0..SLOTS));
                let action = often.map_or(Action::Cloth, |(action, _)| *action);
                steps.push(Step { frame, action, slot, other, seed: rng.u64(..) });
            }
        }
        Self { setup, steps, frames }
    }

    /// Of a mesh: a cloth of it, with something to fall on, for a few frames.
    pub fn mesh(seed: u64, frames: u32) -> Self {
        let mut rng = Rng::with_seed(seed);
        let setup = Setup { fixed: false, draws: once_in(&mut rng, 20), measures: false, physics: false };
        let mut step = |frame, action, slot| Step { frame, action, slot, other: rng.usize(0..SLOTS), seed: rng.u64(..) };
        let mut steps = vec![step(0, Action::Strange, 0), step(0, Action::Strange, 1), step(0, Action::Body, 2)];
        steps.push(step(frames / 2, Action::Swap, 0));
        Self { setup, steps, frames }
    }
}
