//! Objects that are drawn in place of another, which is simulated.

use bevy::prelude::*;

use super::Nodes;
use super::extras::{self, Problem};
use crate::notices::shortened;

impl Nodes<'_, '_> {
    /// The node called `name` in the scene of `node`, if it is to be a cloth.
    pub(crate) fn simulated(&self, node: Entity, name: &str) -> Result<Entity, Problem> {
        let problem = |what: String| Problem::new("cloth.proxy", what);
        let above = || core::iter::once(node).chain(self.parents.iter_ancestors(node));
        let root = above().find(|at| self.roots.contains(*at)).or_else(|| above().last()).unwrap_or(node);
        let is_named = |at: &Entity| self.names.get(*at).is_ok_and(|known| known.as_str() == name) && *at != node;
        let known: Vec<Entity> = self.children.iter_descendants(root).filter(is_named).collect();
        // A mesh may have the name of its object.
        let read = |at: &Entity| self.extras.get(*at).ok().map(|extras| extras::node(&extras.value, &mut Vec::new()));
        let cloth = known.iter().find(|at| read(at).is_some_and(|node| node.cloth.is_some()));
        let name = shortened(name);
        match (cloth, known.is_empty()) {
            (Some(cloth), _) => Ok(*cloth),
            (None, true) => Err(problem(format!(
                "is `{name}`, and the scene has no other object of that name: name the object that is simulated"
            ))),
            (None, false) => Err(problem(format!("is `{name}`, which is no cloth: set `cloth` to true on that object"))),
        }
    }
}
