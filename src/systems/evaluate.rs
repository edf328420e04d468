//! Evaluate: tells of cloths that had to be taken back.

use bevy::prelude::*;

use crate::components::{Cloth, ClothError, ClothErrorKind, ClothFailed, ClothRecovered, ClothStatus, RecoveryLevel};
use crate::notices::{Notices, label};
use crate::simulation::ClothScratch;

/// Events for recoveries, and an error for a cloth that was stopped.
pub(crate) fn evaluate(
    mut commands: Commands,
    mut notices: ResMut<Notices>,
    mut cloths: Query<(Entity, Option<&Name>, &mut ClothScratch, &mut ClothStatus), With<Cloth>>,
) {
    for (entity, name, mut scratch, mut status) in &mut cloths {
        let Some((level, cause)) = scratch.recovered else { continue };
        scratch.recovered = None;
        commands.trigger(ClothRecovered { entity, level, cause });
        if level != RecoveryLevel::Frozen {
            continue;
        }
        *status = ClothStatus::Failed;
        let error = ClothError {
            kind: ClothErrorKind::Unstable,
            detail: format!(
                "it blew up again and again ({cause:?}) and was stopped at its pose at rest: raise `ClothSolver::substep_rate` or \
                 `ClothMaterial::density`, or lower its stiffness; changing either starts it again"
            ),
        };
        if notices.first(entity, error.kind.name()) {
            warn!("cloth {} was stopped: {error}", label(entity, name));
        }
        commands.entity(entity).try_insert(error.clone());
        commands.trigger(ClothFailed { entity, error });
    }
}
