//! Scales that several rooms of the solver share.

/// Farthest coordinate that is simulated `[m]`: cloth with a particle beyond it is left out, and so is a body.
pub(crate) const FARTHEST: f32 = 1.0e6;
/// Gap that counts as touching, in units of the distance kept (dimensionless): a way that ends there is stopped, friction still
/// acts there, and nothing is pressed closer together than this.
pub(crate) const TOUCHING: f32 = 0.02;
/// Cosine within which two directions count as one (dimensionless): 60°. Normals of a flat piece lie as close, and so do those
/// of layers on each other; those of two bodies that press what is between them lie as close to opposite.
pub(crate) const ALIGNED: f32 = 0.5;
/// Least mobility of what a constraint pushes, as a share of that of the lightest particle in it (dimensionless). A point that
/// hangs by a corner from two that are held would have to go far to matter: `|w| / max(w², 1/16) <= 4`, so no particle goes
/// farther than four times the push.
pub(crate) const LEAST_MOBILITY: f32 = 1.0 / 16.0;
/// Time that cloth takes to respond `[s]`: within it changed fabrics, limits and skeletons are reached, a tangle is drawn to a
/// pose, slow cloth begins to settle, and what was rolled back takes smaller substeps.
pub(crate) const RESPONSE_TIME: f32 = 0.25;
