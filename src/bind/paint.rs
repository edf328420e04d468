//! What is painted on a mesh: colours and attributes as numbers, and maps as numbers of particles.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use crate::components::{ClothColorChannel, ClothMap, ClothPaint};
use crate::solver::rest::RestShape;

/// A channel of the vertex colours; the reason where there are none.
pub(crate) fn color(mesh: &Mesh, channel: ClothColorChannel) -> Result<impl Iterator<Item = f32> + '_, String> {
    let Ok(VertexAttributeValues::Float32x4(colors)) = mesh.try_attribute(Mesh::ATTRIBUTE_COLOR) else {
        return Err("name a colour channel, but its mesh has no vertex colours: paint and export them".into());
    };
    Ok(colors.iter().map(move |c| c[channel as usize]))
}

/// The first component of an attribute; the reason where there is none.
pub(crate) fn attribute<'a>(mesh: &'a Mesh, name: &str) -> Result<Box<dyn Iterator<Item = f32> + 'a>, String> {
    let plain = |n: &str| n.trim_start_matches('_').to_ascii_lowercase();
    let values = mesh
        .try_attributes()
        .ok()
        .and_then(|mut all| all.find(|(attribute, _)| plain(attribute.name) == plain(name)))
        .map(|(_, values)| values);
    let first: Option<Box<dyn Iterator<Item = f32> + 'a>> = match values {
        Some(VertexAttributeValues::Float32(v)) => Some(Box::new(v.iter().copied())),
        Some(VertexAttributeValues::Float32x2(v)) => Some(Box::new(v.iter().map(|x| x[0]))),
        Some(VertexAttributeValues::Float32x3(v)) => Some(Box::new(v.iter().map(|x| x[0]))),
        Some(VertexAttributeValues::Float32x4(v)) => Some(Box::new(v.iter().map(|x| x[0]))),
        Some(VertexAttributeValues::Unorm8x4(v)) => Some(Box::new(v.iter().map(|x| f32::from(x[0]) / 255.0))),
        Some(VertexAttributeValues::Unorm16x4(v)) => Some(Box::new(v.iter().map(|x| f32::from(x[0]) / 65535.0))),
        _ => None,
    };
    first.ok_or_else(|| {
        format!(
            "name the attribute `{name}`, but its mesh has no float attribute of that name: \
             insert it, or register it with `GltfPlugin::add_custom_vertex_attribute` before loading a glTF"
        )
    })
}

/// A map as one number for each particle, clamped to `least..=most`; none where the map is off. Of welded vertices the first one counts.
///
/// # Errors
/// The reason, where what was painted is not there.
pub(crate) fn spread(map: &ClothMap, mesh: &Mesh, rest: &RestShape, (least, most): (f32, f32)) -> Result<Vec<f32>, String> {
    // What is not a number counts as the lower end.
    let usable = |value: f32| if value.is_nan() { least } else { value.clamp(least, most) };
    let (paint, low, high) = match map {
        ClothMap::Off => return Ok(Vec::new()),
        ClothMap::Uniform(value) => return Ok(vec![usable(*value); rest.positions.len()]),
        ClothMap::Painted { paint, low, high } => (paint, usable(*low), usable(*high)),
    };
    let painted: Vec<f32> = match paint {
        ClothPaint::Color(channel) => color(mesh, *channel)?.collect(),
        ClothPaint::Attribute(name) => attribute(mesh, name)?.collect(),
    };
    let mut values = vec![low; rest.positions.len()];
    for (&particle, paint) in rest.particle_of_vertex.iter().zip(painted).rev() {
        let paint = if paint.is_nan() { 0.0 } else { paint.clamp(0.0, 1.0) };
        values[particle as usize] = low + (high - low) * paint;
    }
    Ok(values)
}
