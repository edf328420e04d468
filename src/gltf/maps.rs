//! Maps of the extras, and where they are painted. They say how far a cloth goes from its skin, how far it sinks into it, and
//! how firmly it is drawn to it.

use bevy::prelude::*;
use serde_json::{Map, Value};

use super::extras::{Problem, channel, given, number};
use crate::bind::paint::attribute;
use crate::components::{ClothDrive, ClothLimits, ClothMap, ClothPaint, ClothPinSelect};
use crate::notices::shortened;

/// Attributes that maps are painted in, each with the channel of `_CLOTH_PAINT` that stands in for it.
pub(super) const PIN: &str = "_PIN";
pub(super) const MAX_DISTANCE: &str = "_CLOTH_MAXDIST";
pub(super) const BACKSTOP: &str = "_CLOTH_BACKSTOP";
pub(super) const DRIVE: &str = "_CLOTH_DRIVE";
pub(super) const PAINT: &str = "_CLOTH_PAINT";
const CHANNELS: [(&str, &str); 4] =
    [(PIN, "_CLOTH_PAINT.r"), (MAX_DISTANCE, "_CLOTH_PAINT.g"), (BACKSTOP, "_CLOTH_PAINT.b"), (DRIVE, "_CLOTH_PAINT.a")];

/// The `cloth.backstop` key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BackstopExtras {
    /// `[m]`
    pub distance: ClothMap,
    /// `[m]`
    pub radius: Option<f32>,
}

/// Reads `cloth.max_distance`.
pub(super) fn max_distance(value: &Value, problems: &mut Vec<Problem>) -> Option<ClothMap> {
    let key = "cloth.max_distance";
    let Value::Object(fields) = value else {
        let forms = r#"metres, [low, high], or {"map": "color.g", "low": 0, "high": 0.4}"#;
        return map(key, value, MAX_DISTANCE, forms, problems);
    };
    unknown(key, fields, &["map", "low", "high"], problems);
    let [low, high] = [("low", 0.0), ("high", 1.0)].map(|(name, usual)| real(key, fields, name, problems).unwrap_or(usual));
    paint(key, fields, ClothMap::attribute(MAX_DISTANCE, low, high), problems)
}

/// Reads `cloth.backstop`.
pub(super) fn backstop(value: &Value, problems: &mut Vec<Problem>) -> Option<BackstopExtras> {
    let key = "cloth.backstop";
    let Value::Object(fields) = value else {
        let forms = r#"metres, true, [low, high], or {"distance": 0.02, "radius": 0.1, "map": "color.b"}"#;
        let distance = if *value == Value::Bool(true) { Some(0.0.into()) } else { map(key, value, BACKSTOP, forms, problems) };
        return distance.map(|distance| BackstopExtras { distance, radius: None });
    };
    unknown(key, fields, &["distance", "radius", "map"], problems);
    let distance = match fields.get("distance") {
        Some(value) => map("cloth.backstop.distance", value, BACKSTOP, "metres or [low, high]", problems)?,
        // What is painted is metres.
        None if fields.contains_key("map") => ClothMap::attribute(BACKSTOP, 0.0, 1.0),
        None => 0.0.into(),
    };
    let radius = real(key, fields, "radius", problems);
    Some(BackstopExtras { distance: paint(key, fields, distance, problems)?, radius })
}

/// Reads `cloth.drive`.
pub(super) fn drive(value: &Value, problems: &mut Vec<Problem>) -> Option<ClothDrive> {
    let key = "cloth.drive";
    let Value::Object(fields) = value else {
        let forms = r#"hertz, [low, high], or {"frequency": 4, "damping_ratio": 1, "map": "color.a"}"#;
        return map(key, value, DRIVE, forms, problems).map(|frequency| ClothDrive { frequency, ..default() });
    };
    unknown(key, fields, &["frequency", "damping_ratio", "map"], problems);
    let forms = "hertz or [low, high]";
    let Some(value) = fields.get("frequency") else {
        problems.push(Problem::new("cloth.drive.frequency", format!("is missing: it must be {forms}")));
        return None;
    };
    let frequency = map("cloth.drive.frequency", value, DRIVE, forms, problems)?;
    let damping_ratio = real(key, fields, "damping_ratio", problems).unwrap_or(ClothDrive::default().damping_ratio);
    Some(ClothDrive { frequency: paint(key, fields, frequency, problems)?, damping_ratio })
}

/// False is off, a number the same everywhere, a list from where `attribute` is 0 to where it is 1.
fn map(key: &str, value: &Value, attribute: &str, forms: &str, problems: &mut Vec<Problem>) -> Option<ClothMap> {
    let read = match value {
        Value::Bool(false) => Some(ClothMap::Off),
        Value::Array(ends) => match ends.as_slice() {
            [low, high] => number(low).zip(number(high)).map(|(low, high)| ClothMap::attribute(attribute, low, high)),
            _ => None,
        },
        value => number(value).map(ClothMap::Uniform),
    };
    if read.is_none() {
        let what = if value.is_array() { "a list, not of two numbers".into() } else { given(value) };
        problems.push(Problem::new(key, format!("is {what}: it must be {forms}")));
    }
    read
}

/// A map over what the field `map` names, if there is one; a single number is where that is 1.
fn paint(key: &str, fields: &Map<String, Value>, map: ClothMap, problems: &mut Vec<Problem>) -> Option<ClothMap> {
    let Some(value) = fields.get("map") else { return Some(map) };
    let Some(paint) = value.as_str().and_then(painted) else {
        let what = format!("is {}: it must be `_NAME` of a float attribute or `color.r` (g, b, a)", given(value));
        problems.push(Problem::new(format!("{key}.map"), what));
        return None;
    };
    Some(match map {
        ClothMap::Off => ClothMap::Off,
        ClothMap::Uniform(high) => ClothMap::Painted { paint, low: 0.0, high },
        ClothMap::Painted { low, high, .. } => ClothMap::Painted { paint, low, high },
    })
}

/// What `_NAME` and `color.r` (g, b, a) name.
pub(super) fn painted(name: &str) -> Option<ClothPaint> {
    match channel(name) {
        Some(channel) => Some(ClothPaint::Color(channel)),
        None => (name.starts_with('_') && name.len() > 1).then(|| ClothPaint::Attribute(name.into())),
    }
}

fn real(key: &str, fields: &Map<String, Value>, name: &str, problems: &mut Vec<Problem>) -> Option<f32> {
    let value = fields.get(name)?;
    let read = number(value);
    if read.is_none() {
        problems.push(Problem::new(format!("{key}.{name}"), format!("is {}: it must be a number", given(value))));
    }
    read
}

fn unknown(key: &str, fields: &Map<String, Value>, known: &[&str], problems: &mut Vec<Problem>) {
    for name in fields.keys().filter(|name| !known.contains(&name.as_str())) {
        let what = format!("is not known: the keys are {}", known.join(", "));
        problems.push(Problem::new(format!("{key}.{}", shortened(name)), what));
    }
}

/// The attribute of a mesh that a map of that name is painted in: its own, else its channel of `_CLOTH_PAINT`.
fn place(mesh: &Mesh, name: &str) -> Option<&'static str> {
    let (own, channel) = *CHANNELS.iter().find(|(own, _)| *own == name)?;
    [own, channel].into_iter().find(|name| attribute(mesh, name).is_ok())
}

/// A map over what is there of its paint.
pub(super) fn over(mesh: Option<&Mesh>, mut map: ClothMap) -> ClothMap {
    if let ClothMap::Painted { paint: ClothPaint::Attribute(name), .. } = &mut map
        && let Some(there) = mesh.and_then(|mesh| place(mesh, name))
    {
        *name = there.into();
    }
    map
}

/// Pins over what is there of their paint. Without pins in the extras, the red of `_CLOTH_PAINT` pins where it is painted and
/// no `_PIN` is there.
pub(super) fn pins(mesh: Option<&Mesh>, pins: Option<&ClothPinSelect>) -> Option<ClothPinSelect> {
    match pins {
        Some(ClothPinSelect::Attribute(name)) => {
            let there = mesh.and_then(|mesh| place(mesh, name));
            Some(ClothPinSelect::Attribute(there.map_or_else(|| name.clone(), String::from)))
        }
        Some(pins) => Some(pins.clone()),
        None => {
            let mesh = mesh?;
            let red = place(mesh, PIN).filter(|name| *name != PIN)?;
            let is_painted = attribute(mesh, red).is_ok_and(|mut red| red.any(|weight| weight > 0.0));
            is_painted.then(|| ClothPinSelect::Attribute(red.into()))
        }
    }
}

/// Limits of a cloth; none where there is nothing to limit. A maximum distance that is painted and not spoken of goes up to 1
/// m.
pub(super) fn limits(
    mesh: Option<&Mesh>,
    max_distance: Option<&ClothMap>,
    backstop: Option<&BackstopExtras>,
) -> Option<ClothLimits> {
    let max_distance = match max_distance {
        Some(map) => map.clone(),
        None => {
            let there = mesh.and_then(|mesh| place(mesh, MAX_DISTANCE));
            there.map_or(ClothMap::Off, |name| ClothMap::attribute(name, 0.0, 1.0))
        }
    };
    let backstop_distance = backstop.map_or(ClothMap::Off, |backstop| backstop.distance.clone());
    let usual = ClothLimits::default();
    let backstop_radius = backstop.and_then(|backstop| backstop.radius).unwrap_or(usual.backstop_radius);
    let is_limited = !(max_distance.is_off() && backstop_distance.is_off());
    is_limited.then_some(ClothLimits { max_distance, backstop_distance, backstop_radius, ..usual })
}

/// Tells of attributes whose numbers mean nothing without a key that gives them a range.
pub(super) fn tell_of_idle(mesh: &Mesh, backstop: bool, drive: bool, problems: &mut Vec<Problem>) {
    for (key, said, name, cure) in
        [("cloth.backstop", backstop, BACKSTOP, "[low, high] in metres"), ("cloth.drive", drive, DRIVE, "[low, high] in hertz")]
    {
        // Once for all primitives of a node, and not where the key is wrong.
        let is_told = problems.iter().any(|problem| problem.key.starts_with(key));
        if !said && !is_told && attribute(mesh, name).is_ok() {
            let what = format!("is missing beside the attribute `{name}`: set it to {cure}, or to false to do without");
            problems.push(Problem::new(key, what));
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat};

    use super::*;
    use crate::components::ClothColorChannel;

    fn mesh(attributes: &[&'static str], paint: Option<[f32; 4]>) -> Mesh {
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 3]);
        for (id, name) in (0x00d1_a9e0_0010..).zip(attributes) {
            mesh.insert_attribute(MeshVertexAttribute::new(name, id, VertexFormat::Float32), vec![0.5_f32; 3]);
        }
        if let Some(paint) = paint {
            let attribute = MeshVertexAttribute::new(PAINT, 0x00d1_a9e0_0020, VertexFormat::Float32x4);
            mesh.insert_attribute(attribute, vec![paint; 3]);
        }
        mesh
    }

    #[test]
    fn maps_lie_in_their_own_attribute_else_in_a_channel_of_the_paint() {
        let (single, paint) = (mesh(&[MAX_DISTANCE], Some([0.0; 4])), mesh(&[], Some([0.0; 4])));
        let asked = || ClothMap::attribute(MAX_DISTANCE, 0.0, 0.3);
        assert_eq!(over(Some(&single), asked()), asked());
        assert_eq!(over(Some(&paint), asked()), ClothMap::attribute("_CLOTH_PAINT.g", 0.0, 0.3));
        assert_eq!(
            over(Some(&paint), ClothMap::attribute(BACKSTOP, 0.0, 0.1)),
            ClothMap::attribute("_CLOTH_PAINT.b", 0.0, 0.1)
        );
        assert_eq!(over(Some(&paint), ClothMap::attribute(DRIVE, 0.0, 4.0)), ClothMap::attribute("_CLOTH_PAINT.a", 0.0, 4.0));
        let others = [ClothMap::attribute("_OTHER", 0.0, 1.0), ClothMap::color(ClothColorChannel::G, 0.0, 1.0)];
        for map in others.into_iter().chain([ClothMap::Uniform(0.2), ClothMap::Off]) {
            assert_eq!(over(Some(&paint), map.clone()), map);
        }
        // What is nowhere keeps its name, for the warning.
        assert_eq!([over(Some(&mesh(&[], None)), asked()), over(None, asked())], [asked(), asked()]);
    }

    #[test]
    fn a_painted_distance_that_is_not_spoken_of_goes_up_to_a_metre() {
        let limited =
            |mesh: &Mesh, map: Option<ClothMap>| limits(Some(mesh), map.as_ref(), None).map(|limits| limits.max_distance);
        let (single, paint) = (mesh(&[MAX_DISTANCE], None), mesh(&[], Some([0.0; 4])));
        assert_eq!(limited(&single, None), Some(ClothMap::attribute(MAX_DISTANCE, 0.0, 1.0)));
        assert_eq!(limited(&paint, None), Some(ClothMap::attribute("_CLOTH_PAINT.g", 0.0, 1.0)));
        assert_eq!(limited(&single, Some(ClothMap::Uniform(0.2))), Some(ClothMap::Uniform(0.2)));
        assert_eq!([limited(&single, Some(ClothMap::Off)), limited(&mesh(&[PIN], None), None)], [None, None]);
    }

    #[test]
    fn red_pins_where_it_is_painted_and_nothing_else_is_said() {
        let pinned = |mesh: &Mesh, select: Option<ClothPinSelect>| pins(Some(mesh), select.as_ref());
        let attribute = |name: &str| Some(ClothPinSelect::Attribute(name.into()));
        let red = mesh(&[], Some([1.0, 0.0, 0.0, 0.0]));
        assert_eq!(pinned(&red, None), attribute("_CLOTH_PAINT.r"));
        assert_eq!(pinned(&red, attribute(PIN)), attribute("_CLOTH_PAINT.r"));
        assert_eq!(pinned(&red, attribute("_OTHER")), attribute("_OTHER"));
        let listed = Some(ClothPinSelect::Vertices(vec![0]));
        assert_eq!(pinned(&red, listed.clone()), listed);
        assert_eq!(pinned(&mesh(&[], Some([0.0, 1.0, 1.0, 1.0])), None), None, "nothing is red");
        let both = mesh(&[PIN], Some([1.0; 4]));
        assert_eq!((pinned(&both, None), pinned(&both, attribute(PIN))), (None, attribute(PIN)));
    }
}
