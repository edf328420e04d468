//! What must hold after every frame.

use bevy::camera::primitives::Aabb;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_drape::prelude::*;

use super::mirror::not_finite;
use super::stage::Stage;

/// Most substeps in a frame or tick: 10,000 Hz over 1 s, eight times as many while bodies are fast.
const SUBSTEPS: u32 = 80_000;
/// Time for an inner step of a particle, with everything that it may meet `[s]`.
const STEP: f32 = 4.0e-6;
/// Time for a visit of untangling `[s]`.
const VISIT: f32 = 2.0e-7;
/// Ticks in the longest frame of the fixed schedule.
const TICKS: f32 = 17.0;

/// What does not hold: a kind that stays the same when the case shrinks, and what it was.
pub type Broken = (String, String);

/// The first thing that does not hold.
pub fn after_frame(stage: &mut Stage) -> Option<Broken> {
    shown(stage).or_else(|| reports(stage))
}

/// Meshes that the plugin writes, and their bounds.
fn shown(stage: &mut Stage) -> Option<Broken> {
    type Shown<'a> = (Entity, &'a Mesh3d, &'a ClothStatus, Option<&'a Aabb>);
    let world = stage.app.world_mut();
    let mut query = world.query_filtered::<Shown, (With<ClothParticles>, Allow<Disabled>)>();
    let meshes = world.resource::<Assets<Mesh>>();
    for (entity, mesh, status, bounds) in query.iter(world) {
        // One that the attack made is drawn as it is made.
        if *status != ClothStatus::Active || stage.made.contains(&mesh.id()) {
            continue;
        }
        if let Some(bounds) = bounds
            && !(bounds.center.is_finite()
                && bounds.half_extents.is_finite()
                && bounds.half_extents.cmpge(Vec3::ZERO.into()).all())
        {
            return Some(("bounds that are not finite".into(), format!("{entity}: {bounds:?}")));
        }
        let Some(mesh) = meshes.get(mesh.id()) else { continue };
        let length = |attribute| mesh.try_attribute(attribute).map_or(0, VertexAttributeValues::len);
        let count = length(Mesh::ATTRIBUTE_POSITION);
        for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_TANGENT] {
            // What is not one for each vertex is left as it was made, and tangents without what tells them.
            let is_written = attribute.id != Mesh::ATTRIBUTE_TANGENT.id || length(Mesh::ATTRIBUTE_UV_0) == count;
            if length(attribute) != count || !is_written {
                continue;
            }
            let bad = match mesh.try_attribute(attribute) {
                Ok(VertexAttributeValues::Float32x3(values)) => values.iter().position(|v| v.iter().any(|x| !x.is_finite())),
                Ok(VertexAttributeValues::Float32x4(values)) => values.iter().position(|v| v.iter().any(|x| !x.is_finite())),
                _ => None,
            };
            if let Some(vertex) = bad {
                let what = format!("{entity}: {} of vertex {vertex} of {count}", attribute.name);
                return Some((format!("{} that is not finite", attribute.name), what));
            }
        }
    }
    None
}

/// Reports, contacts and what bodies were given.
fn reports(stage: &mut Stage) -> Option<Broken> {
    type Told<'a> =
        (Entity, Option<&'a ClothReport>, Option<&'a ClothContacts>, Option<&'a ClothReaction>, Option<&'a ClothStatus>);
    let world = stage.app.world_mut();
    let mut query = world.query_filtered::<Told, Allow<Disabled>>();
    for (entity, report, contacts, reaction, status) in query.iter(world) {
        let bad = report
            .and_then(|report| not_finite(report, "report"))
            .or_else(|| not_finite(contacts?, "contacts"))
            .or_else(|| not_finite(reaction?, "reaction"));
        if let Some(bad) = bad {
            let field = bad.split(" = ").next().unwrap_or("").trim_matches(|c: char| c == '.' || c.is_ascii_digit());
            return Some((format!("{field} that is not finite"), format!("{entity}, {status:?}: {bad}")));
        }
        if let Some(report) = report.filter(|report| report.substeps > SUBSTEPS) {
            return Some(("too many substeps".into(), format!("{entity}: {report:?}")));
        }
    }
    None
}

/// What the last frame may have taken for what was to be done `[s]`; without end where the oldest method untangles, which is
/// there to compare with.
pub fn work(stage: &mut Stage) -> f32 {
    let fixed = stage.fixed;
    let world = stage.app.world_mut();
    let mut query = world.query_filtered::<(&ClothReport, &ClothBuildReport, &ClothUntangling), Allow<Disabled>>();
    let of = |(report, build, untangling): (&ClothReport, &ClothBuildReport, &ClothUntangling)| {
        let steps = report.substeps.saturating_mul(report.inner_steps.max(1)) as f32 * build.particles as f32;
        if untangling.method == ClothUntanglingMethod::History {
            return f32::INFINITY;
        }
        let visits = untangling.effort.clamp(16, 1_000_000) as f32 * build.faces as f32;
        steps * STEP + visits * VISIT
    };
    let work: f32 = query.iter(world).map(of).sum();
    if fixed { work * TICKS } else { work }
}

/// How many cloths took substeps in the last frame, and how many of them are tangled.
pub fn busy(stage: &mut Stage) -> [u64; 2] {
    let world = stage.app.world_mut();
    let mut query = world.query_filtered::<&ClothReport, With<ClothParticles>>();
    let busy = query.iter(world).filter(|report| report.substeps > 0);
    busy.fold([0; 2], |[count, tangled], report| [count + 1, tangled + u64::from(report.crossings > 0)])
}

/// Adds the positions of all cloths that have a number to a hash (FNV-1a).
pub fn hash(stage: &Stage, hash: &mut u64) {
    for entity in (0..stage.slots.len()).filter_map(|slot| stage.live(slot)).chain(stage.belongings.iter().copied()) {
        let Some(particles) = stage.app.world().get::<ClothParticles>(entity) else { continue };
        for value in particles.state().positions.iter().flat_map(Vec4::to_array) {
            *hash = (*hash ^ u64::from(value.to_bits())).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
