//! The data of the simulation. A cloth's entity has a component per kind (rest, state, inputs, place, shown). Bodies and air
//! lie around all cloths.
//!
//! None of the components is cloned with the entity: the clone binds anew from the mesh that was authored.

mod air;
mod binding;
mod bodies;
mod coupling;
mod inputs;
mod motion;
mod particles;
mod place;
mod pose;
mod rest;
mod share;
mod shown;
mod slumber;
mod worn;

pub(crate) use air::{WorldAir, reaches};
pub(crate) use binding::{Binding, Change, PieceBinding, TakenSkin, WaitingSince};
pub(crate) use bodies::{NEAR, TELEPORT_SPEED, TELEPORT_SPIN, WorldBodies, WorldBody, WorldRigid, is_near, jumped, swept};
pub(crate) use inputs::{ClothInputs, FIRST_FRAMES};
pub(crate) use motion::Motion;
pub use particles::ClothParticles;
pub(crate) use place::IslandPlace;
pub use pose::ClothPose;
pub use rest::ClothRest;
pub(crate) use shown::ClothShown;
pub(crate) use slumber::{STILL, Seen, SeenBody, Slumber, stays};
pub(crate) use worn::{Bones, Worn};
