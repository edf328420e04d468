//! What is painted on a mesh: colours and attributes as numbers, and maps as numbers of particles.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use crate::components::{ClothColorChannel, ClothMap, ClothPaint};
use crate::solver::rest::RestShape;

impl ClothMap {
    /// What was painted at each vertex of a mesh, as it is there: 0 to 1, unless somebody painted otherwise. None where the map
    /// is not painted.
    ///
    /// # Errors
    /// The reason, where the mesh does not have what the map names.
    #[must_use]
    pub fn painted(&self, mesh: &Mesh) -> Option<Result<Vec<f32>, String>> {
        match self {
            Self::Off | Self::Uniform(_) => None,
            Self::Painted { paint, .. } => Some(painted(paint, mesh)),
        }
    }
}

fn painted(paint: &ClothPaint, mesh: &Mesh) -> Result<Vec<f32>, String> {
    Ok(match paint {
        ClothPaint::Color(channel) => color(mesh, *channel)?.collect(),
        ClothPaint::Attribute(name) => attribute(mesh, name)?.collect(),
    })
}

/// A channel of the vertex colours; the reason where there are none.
pub(crate) fn color(mesh: &Mesh, channel: ClothColorChannel) -> Result<impl Iterator<Item = f32> + '_, String> {
    let Ok(VertexAttributeValues::Float32x4(colors)) = mesh.try_attribute(Mesh::ATTRIBUTE_COLOR) else {
        return Err("name a colour channel, but its mesh has no vertex colours: paint and export them".into());
    };
    Ok(colors.iter().map(move |c| c[channel as usize]))
}

/// An attribute, or the component of it that is named behind a dot, such as `_CLOTH_PAINT.g`; the reason where there is none.
pub(crate) fn attribute<'a>(mesh: &'a Mesh, name: &str) -> Result<Box<dyn Iterator<Item = f32> + 'a>, String> {
    // A name may have a dot of its own.
    let (values, base, component) = match (values(mesh, name), component(name)) {
        (None, Some((base, component))) => (values(mesh, base), base, component),
        (values, _) => (values, name, 0),
    };
    let numbers: Option<Box<dyn Iterator<Item = f32> + 'a>> = match values {
        Some(VertexAttributeValues::Float32(v)) if component == 0 => Some(Box::new(v.iter().copied())),
        Some(VertexAttributeValues::Float32x2(v)) if component < 2 => Some(Box::new(v.iter().map(move |x| x[component]))),
        Some(VertexAttributeValues::Float32x3(v)) if component < 3 => Some(Box::new(v.iter().map(move |x| x[component]))),
        Some(VertexAttributeValues::Float32x4(v)) => Some(Box::new(v.iter().map(move |x| x[component]))),
        Some(VertexAttributeValues::Unorm8x4(v)) => Some(Box::new(v.iter().map(move |x| f32::from(x[component]) / 255.0))),
        Some(VertexAttributeValues::Unorm16x4(v)) => Some(Box::new(v.iter().map(move |x| f32::from(x[component]) / 65535.0))),
        _ => None,
    };
    numbers.ok_or_else(|| match values {
        Some(_) if component > 0 => format!("name `{name}`, but the attribute `{base}` has no such component of floats"),
        _ => format!(
            "name the attribute `{base}`, but its mesh has no float attribute of that name: \
             insert it, or register it with `GltfPlugin::add_custom_vertex_attribute` before loading a glTF, as `gltf::cloth_attributes` does"
        ),
    })
}

/// The values of an attribute. The loader of glTFs drops the first underscore of names, and programs write them in capitals.
fn values<'a>(mesh: &'a Mesh, name: &str) -> Option<&'a VertexAttributeValues> {
    let plain = |n: &str| n.trim_start_matches('_').to_ascii_lowercase();
    let name = plain(name);
    mesh.try_attributes().ok()?.find(|(attribute, _)| plain(attribute.name) == name).map(|(_, values)| values)
}

/// A name without the component behind its dot, and which one that is.
fn component(name: &str) -> Option<(&str, usize)> {
    let (base, last) = name.rsplit_once('.')?;
    let component = ["r", "g", "b", "a"].into_iter().position(|letter| last.eq_ignore_ascii_case(letter))?;
    Some((base, component))
}

/// A map as one number for each particle, clamped to `least..=most`; none where the map is off. Of welded vertices the first
/// one counts.
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
    let painted = painted(paint, mesh)?;
    let mut values = vec![low; rest.positions.len()];
    for (v, (&particle, paint)) in rest.particle_of_vertex.iter().zip(painted).enumerate().rev() {
        if rest.is_gone(v as u32) {
            continue;
        }
        let paint = if paint.is_nan() { 0.0 } else { paint.clamp(0.0, 1.0) };
        values[particle as usize] = low + (high - low) * paint;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat};

    use super::*;

    #[test]
    fn a_component_of_an_attribute_is_named_behind_a_dot() {
        let paint = MeshVertexAttribute::new("_CLOTH_PAINT", 0x00d1_a9e0_0002, VertexFormat::Float32x4);
        let weight = MeshVertexAttribute::new("_WEIGHT", 0x00d1_a9e0_0003, VertexFormat::Float32);
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 2])
            .with_inserted_attribute(paint, vec![[0.1_f32, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.8]])
            .with_inserted_attribute(weight, vec![0.9_f32, 1.0]);
        let read = |name: &str| attribute(&mesh, name).map(Iterator::collect::<Vec<f32>>);
        for (name, numbers) in [
            ("_CLOTH_PAINT", [0.1, 0.5]),
            ("_CLOTH_PAINT.r", [0.1, 0.5]),
            ("_CLOTH_PAINT.g", [0.2, 0.6]),
            ("cloth_paint.B", [0.3, 0.7]),
            ("_CLOTH_PAINT.a", [0.4, 0.8]),
            ("_WEIGHT", [0.9, 1.0]),
            ("_WEIGHT.r", [0.9, 1.0]),
        ] {
            assert_eq!(read(name), Ok(numbers.to_vec()), "{name}");
        }
        for (name, reason) in
            [("_WEIGHT.g", "`_WEIGHT` has no such component"), ("_OTHER.g", "`_OTHER`"), ("_WEIGHT.x", "`_WEIGHT.x`")]
        {
            let error = read(name).err().unwrap_or_default();
            assert!(error.contains(reason), "{name}: {error}");
        }
    }
}
