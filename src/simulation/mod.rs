//! What the simulation keeps on a cloth's entity, a component per kind of data: rest, state, inputs, scratch, shown.
//!
//! None of these is cloned with the entity: the clone binds anew from the mesh that was authored.

mod binding;
mod inputs;
mod particles;
mod rest;
mod scratch;
mod shown;

pub(crate) use binding::{Binding, Change, TakenSkin, WaitingSince};
pub(crate) use inputs::ClothInputs;
pub use particles::ClothParticles;
pub use rest::ClothRest;
pub(crate) use scratch::ClothScratch;
pub(crate) use shown::ClothShown;
