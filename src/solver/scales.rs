//! Scales that several modules of the solver share.

/// Farthest coordinate that is simulated `[m]`. Cloth with a particle beyond it is left out, and a shape with a coordinate or a
/// size beyond it is refused.
pub(crate) const FARTHEST: f32 = 1.0e6;
/// Gap that counts as touching, in units of the distance kept (dimensionless). A way that ends there is stopped, friction still
/// acts there, and nothing is pressed closer together than this.
pub(crate) const TOUCHING: f32 = 0.02;
/// Cosine within which two directions count as one (dimensionless): 60°. Normals of a flat piece lie as close, and so do those
/// of layers on each other. Those of two bodies that press on what is between them lie as close to opposite.
pub(crate) const ALIGNED: f32 = 0.5;
/// Least mobility of what a constraint pushes, as a share of that of its lightest particle (dimensionless). A point that hangs
/// by a corner from two that are held would have to go far to matter. Pairs and triangles divide by no less, so that in a pair
/// no particle goes farther than four times the push: `|w| / max(w², 1/16) <= 4`.
pub(crate) const LEAST_MOBILITY: f32 = 1.0 / 16.0;
/// Time over which cloth changes or is watched `[s]`. Within it changed fabrics, limits, anchors and skeletons are reached, and
/// a tangle is drawn to a pose. Cloth that is slow for as long begins to settle, and as long after a rollback substeps are
/// smaller.
pub(crate) const RESPONSE_TIME: f32 = 0.25;
