//! One short system per stage: query, call the solver, record. [`crate::plugin`] orders them.

pub(crate) mod bind;
pub(crate) mod colliders;
pub(crate) mod evaluate;
pub(crate) mod inputs;
pub(crate) mod integrate;
pub(crate) mod release;
pub(crate) mod sources;
pub(crate) mod sync;
