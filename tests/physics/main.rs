//! Cloth is physics, without an engine: laws, fabrics, skinned constraints.

mod characters;
mod cloth;
mod fabrics;
