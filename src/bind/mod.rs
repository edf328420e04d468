//! From a mesh asset to a rest shape: read, bake the scale, share, pin. And from meshes to shapes of colliders.

mod anchors;
mod cache;
mod character;
mod crossfade;
mod fine;
mod follow;
mod instance;
pub(crate) mod paint;
mod placement;
mod read;
mod shapes;
mod skin;
mod subdivide;
mod surface;

pub(crate) use anchors::{AnchorSet, AnchorSets, Continuing, Resolved, ramp_weights, resolve};
pub(crate) use cache::{RestCache, RestOf, Sources};
pub(crate) use character::{BodyCache, BodyError, BodyKey, BodyWait, SkinnedVertices, collider_of, margin_of};
pub(crate) use crossfade::Crossfade;
pub(crate) use fine::{FineMesh, Vertices};
pub(crate) use follow::{Asked, Followed};
pub(crate) use instance::{bounds_between, corners, instance_of};
pub(crate) use placement::{Placement, is_near, seen_from, uniform_scale};
pub(crate) use read::{Authored, read, unreadable};
pub(crate) use shapes::{ColliderError, shape_of};
pub(crate) use skin::{Skin, Transforms, joints_above, skinning_matrices};
pub(crate) use subdivide::{MOST_VERTICES, Subdivided, subdivide};
pub(crate) use surface::{Surface, VertexBuffers};
