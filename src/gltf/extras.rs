//! From the text of extras to what they mean. Every problem is collected; nothing stops the rest.

use bevy::math::Vec3;
use serde_json::{Map, Value};

use super::maps::{self, BackstopExtras};
use crate::components::{
    ClothCollisionLayers, ClothColorChannel, ClothDrive, ClothInertia, ClothMap, ClothMaterial, ClothMeshFit, ClothPaint,
    ClothPinSelect,
};
use crate::notices::shortened;

/// A key that could not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Problem {
    pub key: String,
    pub what: String,
}

impl Problem {
    pub(crate) fn new(key: impl Into<String>, what: impl Into<String>) -> Self {
        Self { key: key.into(), what: what.into() }
    }
}

/// Extras of a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct NodeExtras {
    pub cloth: Option<ClothExtras>,
    /// The object that is simulated in place of this one.
    pub proxy: Option<String>,
    pub collider: Option<ColliderExtras>,
    pub layers: Option<ClothCollisionLayers>,
}

/// The `cloth` key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ClothExtras {
    pub material: Option<MaterialExtras>,
    pub pin: Option<ClothPinSelect>,
    pub self_collision: Option<bool>,
    pub layer: Option<i32>,
    pub thickness: Option<f32>,
    pub substep_rate: Option<f32>,
    /// `[m]`; off where it was switched off.
    pub max_distance: Option<ClothMap>,
    pub backstop: Option<BackstopExtras>,
    pub drive: Option<ClothDrive>,
    pub inertia: Option<ClothInertia>,
    /// How much of it is simulated (dimensionless).
    pub blend: Option<f32>,
    /// Time that is simulated before it is shown `[s]`.
    pub warm_up: Option<f32>,
    /// Longest edge that is left `[m]`.
    pub subdivision: Option<f32>,
    /// Shortest edge that is simulated `[m]`.
    pub decimation: Option<f32>,
}

/// The `cloth.material` key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MaterialExtras {
    Given(Box<ClothMaterial>),
    File(String),
}

/// The `collider` key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColliderExtras {
    pub fit: ColliderFit,
    pub friction: Option<f32>,
}

/// What a collider is fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColliderFit {
    /// The mesh of the node.
    Mesh(ClothMeshFit),
    /// The bones of every skinned mesh at or below the node.
    Skeleton,
}

/// Extras of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SceneExtras {
    pub gravity: Option<Vec3>,
    pub wind: Option<Vec3>,
}

/// Reads the extras of a node. Keys of other programs are none of our business.
pub(crate) fn node(text: &str, problems: &mut Vec<Problem>) -> NodeExtras {
    let Some(extras) = object(text) else { return NodeExtras::default() };
    let mut keys = Map::new();
    let mut is_cloth = false;
    match extras.get("cloth") {
        None => {}
        Some(Value::Object(object)) => {
            is_cloth = true;
            keys = object.clone();
        }
        Some(value) => match boolean(value) {
            Some(yes) => is_cloth = yes,
            None => problems.push(Problem::new("cloth", format!("is {}: it must be true or an object", kind(value)))),
        },
    }
    for (key, value) in &extras {
        if let Some(flat) = key.strip_prefix("cloth.") {
            keys.insert(flat.into(), value.clone());
        }
    }
    let proxy = match keys.remove("proxy") {
        None => None,
        Some(Value::String(name)) => Some(name),
        Some(value) => {
            let what = format!("is {}: it must be the name of the object that is simulated", kind(&value));
            problems.push(Problem::new("cloth.proxy", what));
            None
        }
    };
    if proxy.is_some() {
        if !keys.is_empty() {
            problems.push(Problem::new(
                "cloth.proxy",
                "is beside other `cloth.…` keys, which count on the object that is simulated: move them there",
            ));
        }
        (is_cloth, keys) = (false, Map::new());
    }
    if !is_cloth && !keys.is_empty() {
        problems.push(Problem::new("cloth", "is missing or false beside `cloth.…` keys: set it to true"));
    }
    NodeExtras {
        cloth: is_cloth.then(|| cloth(&keys, problems)),
        proxy,
        collider: extras.get("collider").and_then(|value| collider(value, problems)),
        layers: layers(&extras, problems),
    }
}

/// Reads the keys `collision_memberships` and `collision_filters`: the number of a layer, or a list of them.
fn layers(extras: &Map<String, Value>, problems: &mut Vec<Problem>) -> Option<ClothCollisionLayers> {
    let mut bits = |key: &str| {
        let value = extras.get(key)?;
        // A property of Blender is a float unless it is told otherwise.
        let whole = |value: &Value| value.as_f64().filter(|layer| layer.fract() == 0.0 && (0.0..32.0).contains(layer));
        let bit = |value: &Value| whole(value).map(|layer| 1_u32 << layer as u32);
        let bits = match value {
            Value::Array(layers) => layers.iter().map(bit).try_fold(0, |all, bit| Some(all | bit?)),
            layer => bit(layer),
        };
        if bits.is_none() {
            let what = format!("is {}: it must be the number of a layer, 0 to 31, or a list of such", given(value));
            problems.push(Problem::new(key, what));
        }
        bits
    };
    let (memberships, filters) = (bits("collision_memberships"), bits("collision_filters"));
    let ClothCollisionLayers { memberships: usual, filters: all } = ClothCollisionLayers::DEFAULT;
    (memberships.is_some() || filters.is_some())
        .then(|| ClothCollisionLayers::new(memberships.unwrap_or(usual), filters.unwrap_or(all)))
}

/// Reads the extras of a scene.
pub(crate) fn scene(text: &str, problems: &mut Vec<Problem>) -> SceneExtras {
    let Some(extras) = object(text) else { return SceneExtras::default() };
    let mut vector = |key: &str| {
        let value = extras.get(key)?;
        let read = value.as_array().filter(|a| a.len() == 3).and_then(|a| {
            let [x, y, z] = [0, 1, 2].map(|i| number(&a[i]));
            Some(Vec3::new(x?, y?, z?))
        });
        if read.is_none() {
            problems.push(Problem::new(key, format!("is {}: it must be a list of three numbers", kind(value))));
        }
        read
    };
    SceneExtras { gravity: vector("gravity"), wind: vector("wind") }
}

fn cloth(keys: &Map<String, Value>, problems: &mut Vec<Problem>) -> ClothExtras {
    let mut cloth = ClothExtras::default();
    for (key, value) in keys {
        let expected = match key.as_str() {
            "material" => {
                cloth.material = material(value, problems);
                continue;
            }
            "pin" => {
                cloth.pin = pin(value, problems);
                continue;
            }
            "max_distance" => {
                cloth.max_distance = maps::max_distance(value, problems);
                continue;
            }
            "backstop" => {
                cloth.backstop = maps::backstop(value, problems);
                continue;
            }
            "drive" => {
                cloth.drive = maps::drive(value, problems);
                continue;
            }
            "inertia" => {
                cloth.inertia = inertia(value, problems);
                continue;
            }
            "blend" => {
                cloth.blend = number(value);
                cloth.blend.is_none().then_some("a number from 0, animated, to 1, simulated")
            }
            "warm_up" => {
                cloth.warm_up = number(value).filter(|seconds| *seconds >= 0.0);
                cloth.warm_up.is_none().then_some("a number of seconds, of 0 or more")
            }
            "subdivision" => {
                cloth.subdivision = number(value).filter(|longest| *longest > 0.0);
                cloth.subdivision.is_none().then_some("a number of metres, of more than 0")
            }
            "decimation" => {
                cloth.decimation = number(value).filter(|shortest| *shortest > 0.0 && shortest.is_finite());
                cloth.decimation.is_none().then_some("a number of metres, of more than 0")
            }
            "self_collision" => {
                cloth.self_collision = boolean(value);
                cloth.self_collision.is_none().then_some("true or false")
            }
            "layer" => {
                cloth.layer = value.as_i64().and_then(|i| i32::try_from(i).ok());
                cloth.layer.is_none().then_some("an integer")
            }
            "thickness" => {
                cloth.thickness = number(value);
                cloth.thickness.is_none().then_some("a number of metres")
            }
            "substep_rate" => {
                cloth.substep_rate = number(value);
                cloth.substep_rate.is_none().then_some("a number of hertz")
            }
            _ => {
                let known = "material, pin, self_collision, layer, thickness, substep_rate, max_distance, backstop, drive, inertia, blend, warm_up, subdivision, decimation, proxy";
                problems.push(Problem::new(format!("cloth.{}", shortened(key)), format!("is not known: the keys are {known}")));
                continue;
            }
        };
        if let Some(expected) = expected {
            problems.push(Problem::new(format!("cloth.{key}"), format!("is {}: it must be {expected}", kind(value))));
        }
    }
    cloth
}

fn material(value: &Value, problems: &mut Vec<Problem>) -> Option<MaterialExtras> {
    let key = "cloth.material";
    match value {
        Value::String(name) if name.ends_with(".ron") => Some(MaterialExtras::File(name.clone())),
        Value::String(name) => {
            let preset = ClothMaterial::preset(name);
            if preset.is_none() {
                let names: Vec<&str> = ClothMaterial::PRESETS.iter().map(|(n, _)| *n).collect();
                let what =
                    format!("is `{}`: it must be one of {} or a path to a `.cloth.ron`", shortened(name), names.join(", "));
                problems.push(Problem::new(key, what));
            }
            preset.map(Box::new).map(MaterialExtras::Given)
        }
        Value::Object(fields) => {
            let mut material = ClothMaterial::default();
            for (field, value) in fields {
                let place = format!("{key}.{}", shortened(field));
                match (material.field_mut(field), number(value)) {
                    (Some(slot), Some(number)) => *slot = number,
                    (None, _) => problems.push(Problem::new(place, "is not a field of ClothMaterial")),
                    (_, None) => problems.push(Problem::new(place, format!("is {}: it must be a number", kind(value)))),
                }
            }
            Some(MaterialExtras::Given(Box::new(material)))
        }
        _ => {
            problems.push(Problem::new(key, format!("is {}: it must be a name, a path or an object", kind(value))));
            None
        }
    }
}

fn inertia(value: &Value, problems: &mut Vec<Problem>) -> Option<ClothInertia> {
    let key = "cloth.inertia";
    match value {
        Value::Object(fields) => {
            let mut inertia = ClothInertia::default();
            for (field, value) in fields {
                let slot = match field.as_str() {
                    "linear" => &mut inertia.linear,
                    "angular" => &mut inertia.angular,
                    "max_speed" => &mut inertia.max_speed,
                    "max_turn" => &mut inertia.max_turn,
                    _ => {
                        let known = "linear, angular, max_speed, max_turn";
                        let what = format!("is not known: the keys are {known}");
                        problems.push(Problem::new(format!("{key}.{}", shortened(field)), what));
                        continue;
                    }
                };
                match number(value) {
                    Some(number) => *slot = number,
                    None => {
                        let what = format!("is {}: it must be a number", kind(value));
                        problems.push(Problem::new(format!("{key}.{field}"), what));
                    }
                }
            }
            Some(inertia)
        }
        _ => match (number(value), value.as_str()) {
            (Some(share), _) => Some(ClothInertia { linear: share, angular: share, ..ClothInertia::default() }),
            (_, Some("world")) => Some(ClothInertia::default()),
            (_, Some("character")) => Some(ClothInertia::CHARACTER),
            _ => {
                let what = format!("is {}: it must be a number from 0 to 1, `world`, `character` or an object", given(value));
                problems.push(Problem::new(key, what));
                None
            }
        },
    }
}

fn pin(value: &Value, problems: &mut Vec<Problem>) -> Option<ClothPinSelect> {
    let wrong = |what: String| Problem::new("cloth.pin", what);
    match value {
        Value::Array(list) => {
            let index = |v: &Value| v.as_u64().and_then(|i| u32::try_from(i).ok());
            let vertices: Vec<u32> = list.iter().filter_map(index).collect();
            if vertices.len() < list.len() {
                let bad = list.len() - vertices.len();
                problems.push(wrong(format!("has {bad} entries that are not vertex indices; the others are used")));
            }
            Some(ClothPinSelect::Vertices(vertices))
        }
        _ => match value.as_str().and_then(maps::painted) {
            Some(ClothPaint::Attribute(name)) => Some(ClothPinSelect::Attribute(name)),
            Some(ClothPaint::Color(channel)) => Some(ClothPinSelect::Color(channel)),
            None => {
                let what = format!("is {}: it must be a list of indices, `_NAME` or `color.r` (g, b, a)", given(value));
                problems.push(wrong(what));
                None
            }
        },
    }
}

fn collider(value: &Value, problems: &mut Vec<Problem>) -> Option<ColliderExtras> {
    let shape = |value: &Value, key: &str, problems: &mut Vec<Problem>| {
        let fit = match value.as_str().map(str::to_ascii_lowercase).as_deref() {
            Some("ball") => Some(ColliderFit::Mesh(ClothMeshFit::Ball)),
            Some("capsule") => Some(ColliderFit::Mesh(ClothMeshFit::Capsule)),
            Some("cuboid") => Some(ColliderFit::Mesh(ClothMeshFit::Cuboid)),
            Some("convex") => Some(ColliderFit::Mesh(ClothMeshFit::ConvexHull)),
            Some("trimesh") => Some(ColliderFit::Mesh(ClothMeshFit::TriMesh)),
            Some("plane") => Some(ColliderFit::Mesh(ClothMeshFit::HalfSpace)),
            Some("skeleton") => Some(ColliderFit::Skeleton),
            _ => None,
        };
        if fit.is_none() {
            let known = "ball, capsule, cuboid, convex, trimesh, plane, skeleton";
            problems.push(Problem::new(key, format!("is {}: it must be one of {known}", given(value))));
        }
        fit
    };
    let Value::Object(object) = value else {
        return shape(value, "collider", problems).map(|fit| ColliderExtras { fit, friction: None });
    };
    let fit = match object.get("shape") {
        Some(value) => shape(value, "collider.shape", problems),
        None => {
            problems.push(Problem::new("collider.shape", "is missing"));
            None
        }
    };
    let friction = object.get("friction").and_then(|value| {
        let friction = number(value);
        if friction.is_none() {
            problems.push(Problem::new("collider.friction", format!("is {}: it must be a number", kind(value))));
        }
        friction
    });
    for key in object.keys().filter(|key| !["shape", "friction"].contains(&key.as_str())) {
        problems.push(Problem::new(format!("collider.{}", shortened(key)), "is not known: the keys are shape, friction"));
    }
    fit.map(|fit| ColliderExtras { fit, friction })
}

fn object(text: &str) -> Option<Map<String, Value>> {
    match serde_json::from_str(text) {
        Ok(Value::Object(object)) => Some(object),
        _ => None,
    }
}

/// A bool, or 0 or 1 as programs without bools write it.
fn boolean(value: &Value) -> Option<bool> {
    value.as_bool().or(match value.as_i64() {
        Some(0) => Some(false),
        Some(1) => Some(true),
        _ => None,
    })
}

/// The channel of the vertex colour that `color.r` (g, b, a) names.
pub(super) fn channel(name: &str) -> Option<ClothColorChannel> {
    match name.to_ascii_lowercase().as_str() {
        "color.r" => Some(ClothColorChannel::R),
        "color.g" => Some(ClothColorChannel::G),
        "color.b" => Some(ClothColorChannel::B),
        "color.a" => Some(ClothColorChannel::A),
        _ => None,
    }
}

pub(super) fn number(value: &Value) -> Option<f32> {
    value.as_f64().map(|x| x as f32).filter(|x| x.is_finite())
}

/// What was given, in words: a text as it is.
pub(super) fn given(value: &Value) -> String {
    value.as_str().map_or_else(|| kind(value).to_string(), |text| format!("`{}`", shortened(text)))
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a bool",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (NodeExtras, Vec<String>) {
        let mut problems = Vec::new();
        let node = node(text, &mut problems);
        (node, problems.into_iter().map(|p| p.key).collect())
    }

    #[test]
    fn true_is_a_cloth_with_defaults_and_keys_of_others_are_ignored() {
        let (node, problems) = read(r#"{"cloth": true, "my_tool": {"x": 1}}"#);
        assert_eq!((node.cloth, node.collider, problems), (Some(ClothExtras::default()), None, vec![]));
        assert_eq!(read(r#"{"cloth": false}"#).0, NodeExtras::default());
        assert_eq!(read("[1, 2"), (NodeExtras::default(), vec![]));
    }

    #[test]
    fn layers_are_numbers_and_lists_of_them_on_any_node() {
        let layers = |text: &str| {
            let (node, problems) = read(text);
            (node.layers, problems)
        };
        let some = |memberships, filters| Some(ClothCollisionLayers::new(memberships, filters));
        assert_eq!(layers(r#"{"collision_memberships": 1.0}"#), (some(0b10, u32::MAX), vec![]));
        assert_eq!(layers(r#"{"cloth": true, "collision_filters": [0, 2]}"#), (some(1, 0b101), vec![]));
        assert_eq!(layers(r#"{"collision_memberships": [], "collision_filters": 31}"#), (some(0, 1 << 31), vec![]));
        for bad in ["32", "-1", "0.5", "\"hand\"", "[0, true]", "null"] {
            let (layers, problems) = layers(&format!(r#"{{"collision_filters": {bad}}}"#));
            assert_eq!((layers, problems), (None, vec![String::from("collision_filters")]), "{bad}");
        }
    }

    #[test]
    fn every_key_of_the_contract_is_read() {
        let (node, problems) = read(
            r#"{"cloth": {"material": "Silk", "pin": [0, 3], "self_collision": false, "layer": 2, "thickness": 0.01, "substep_rate": 600,
                "max_distance": 0.3, "backstop": {"distance": 0.02, "radius": 0.1}, "drive": {"frequency": 4, "damping_ratio": 0.5}},
                "collider": {"shape": "capsule", "friction": 0.1}}"#,
        );
        let expected = ClothExtras {
            material: Some(MaterialExtras::Given(Box::new(ClothMaterial::SILK))),
            pin: Some(ClothPinSelect::Vertices(vec![0, 3])),
            self_collision: Some(false),
            layer: Some(2),
            thickness: Some(0.01),
            substep_rate: Some(600.0),
            max_distance: Some(ClothMap::Uniform(0.3)),
            backstop: Some(BackstopExtras { distance: ClothMap::Uniform(0.02), radius: Some(0.1) }),
            drive: Some(ClothDrive { frequency: ClothMap::Uniform(4.0), damping_ratio: 0.5 }),
            inertia: None,
            blend: None,
            warm_up: None,
            subdivision: None,
            decimation: None,
        };
        assert_eq!(node.cloth, Some(expected));
        assert_eq!(node.collider, Some(ColliderExtras { fit: ColliderFit::Mesh(ClothMeshFit::Capsule), friction: Some(0.1) }));
        assert!(problems.is_empty(), "{problems:?}");
    }

    #[test]
    fn materials_are_presets_paths_or_fields_over_the_default() {
        let material = |text: &str| read(text).0.cloth.and_then(|c| c.material);
        assert_eq!(material(r#"{"cloth": {"material": "a/b.cloth.ron"}}"#), Some(MaterialExtras::File("a/b.cloth.ron".into())));
        let given = ClothMaterial { density: 0.7, ..ClothMaterial::default() };
        assert_eq!(material(r#"{"cloth": {"material": {"density": 0.7}}}"#), Some(MaterialExtras::Given(Box::new(given))));
    }

    #[test]
    fn pins_are_indices_attributes_or_colour_channels_nested_or_flat() {
        let pin = |text: &str| read(text).0.cloth.and_then(|c| c.pin);
        assert_eq!(pin(r#"{"cloth": {"pin": "_PIN"}}"#), Some(ClothPinSelect::Attribute("_PIN".into())));
        assert_eq!(pin(r#"{"cloth": {"pin": "color.g"}}"#), Some(ClothPinSelect::Color(ClothColorChannel::G)));
        assert_eq!(pin(r#"{"cloth": 1, "cloth.pin": [7]}"#), Some(ClothPinSelect::Vertices(vec![7])));
    }

    #[test]
    fn inertia_is_a_number_a_word_or_an_object_and_blend_a_number() {
        let of = |value: &str| {
            let (node, problems) = read(&format!(r#"{{"cloth": true, "cloth.inertia": {value}}}"#));
            (node.cloth.and_then(|cloth| cloth.inertia), problems)
        };
        let good = |value: &str| {
            let (inertia, problems) = of(value);
            assert_eq!(problems, [""; 0], "{value}");
            inertia
        };
        assert_eq!(good("0.5"), Some(ClothInertia { linear: 0.5, angular: 0.5, ..ClothInertia::default() }));
        assert_eq!(good(r#""world""#), Some(ClothInertia::default()));
        assert_eq!(good(r#""character""#), Some(ClothInertia::CHARACTER));
        let fields = r#"{"linear": 0.2, "max_speed": 3}"#;
        assert_eq!(good(fields), Some(ClothInertia { linear: 0.2, max_speed: 3.0, ..ClothInertia::default() }));
        for bad in [r#""sea""#, "true", r#"{"speed": 1}"#, r#"{"linear": "all"}"#] {
            assert_eq!(of(bad).1.len(), 1, "{bad}");
        }
        let blend = |value: &str| read(&format!(r#"{{"cloth": {{"blend": {value}}}}}"#));
        assert_eq!(blend("0.25").0.cloth.and_then(|cloth| cloth.blend), Some(0.25));
        assert_eq!(blend(r#""half""#).1.len(), 1);
        let warm_up = |value: &str| read(&format!(r#"{{"cloth": {{"warm_up": {value}}}}}"#));
        assert_eq!(warm_up("1.5").0.cloth.and_then(|cloth| cloth.warm_up), Some(1.5));
        assert!(["-1", "true"].iter().all(|value| warm_up(value).1.len() == 1));
        let subdivision = |value: &str| read(&format!(r#"{{"cloth": {{"subdivision": {value}}}}}"#));
        assert_eq!(subdivision("0.03").0.cloth.and_then(|cloth| cloth.subdivision), Some(0.03));
        assert!(["0", "-1", "true"].iter().all(|value| subdivision(value).1.len() == 1));
        let decimation = |value: &str| read(&format!(r#"{{"cloth": {{"decimation": {value}}}}}"#));
        assert_eq!(decimation("0.03").0.cloth.and_then(|cloth| cloth.decimation), Some(0.03));
        assert!(["0", "-1", "true"].iter().all(|value| decimation(value).1.len() == 1));
    }

    #[test]
    fn a_skeleton_is_a_collider_with_or_without_friction() {
        let of = |text: &str| read(text).0.collider.map(|collider| (collider.fit, collider.friction));
        assert_eq!(of(r#"{"collider": "Skeleton"}"#), Some((ColliderFit::Skeleton, None)));
        assert_eq!(of(r#"{"collider": {"shape": "skeleton", "friction": 0.2}}"#), Some((ColliderFit::Skeleton, Some(0.2))));
    }

    #[test]
    fn distances_are_numbers_ranges_of_an_attribute_or_of_what_a_map_names_nested_or_flat() {
        let distance = |value: &str| {
            let nested = read(&format!(r#"{{"cloth": {{"max_distance": {value}}}}}"#));
            assert_eq!(nested, read(&format!(r#"{{"cloth": true, "cloth.max_distance": {value}}}"#)));
            assert_eq!(nested.1, [""; 0], "{value}");
            nested.0.cloth.and_then(|cloth| cloth.max_distance)
        };
        let attribute = |low: f32, high: f32| Some(ClothMap::attribute("_CLOTH_MAXDIST", low, high));
        assert_eq!(distance("0.3"), Some(ClothMap::Uniform(0.3)));
        assert_eq!(distance("false"), Some(ClothMap::Off));
        assert_eq!(distance("[0.01, 0.4]"), attribute(0.01, 0.4));
        assert_eq!(distance("{}"), attribute(0.0, 1.0));
        assert_eq!(distance(r#"{"high": 0.4}"#), attribute(0.0, 0.4));
        let green = Some(ClothMap::color(ClothColorChannel::G, 0.0, 0.4));
        assert_eq!(distance(r#"{"map": "color.g", "low": 0, "high": 0.4}"#), green);
        assert_eq!(distance(r#"{"map": "_MINE.b"}"#), Some(ClothMap::attribute("_MINE.b", 0.0, 1.0)));
    }

    #[test]
    fn backstops_are_true_or_as_distances_with_a_radius() {
        let backstop = |value: &str| {
            let (node, problems) = read(&format!(r#"{{"cloth": {{"backstop": {value}}}}}"#));
            assert_eq!(problems, [""; 0], "{value}");
            node.cloth.and_then(|cloth| cloth.backstop)
        };
        let of = |distance: ClothMap, radius: Option<f32>| Some(BackstopExtras { distance, radius });
        assert_eq!(backstop("true"), of(ClothMap::Uniform(0.0), None));
        assert_eq!(backstop("false"), of(ClothMap::Off, None));
        assert_eq!(backstop("0.02"), of(ClothMap::Uniform(0.02), None));
        assert_eq!(backstop("[-0.01, 0.1]"), of(ClothMap::attribute("_CLOTH_BACKSTOP", -0.01, 0.1), None));
        assert_eq!(backstop(r#"{"radius": 0.2}"#), of(ClothMap::Uniform(0.0), Some(0.2)));
        let blue = |high: f32| ClothMap::color(ClothColorChannel::B, 0.0, high);
        assert_eq!(backstop(r#"{"map": "color.b"}"#), of(blue(1.0), None));
        assert_eq!(backstop(r#"{"map": "color.b", "distance": 0.1, "radius": 2}"#), of(blue(0.1), Some(2.0)));
        assert_eq!(backstop(r#"{"map": "color.b", "distance": [0, 0.3]}"#), of(blue(0.3), None));
    }

    #[test]
    fn drives_are_hertz_or_a_range_of_hertz_with_a_damping_ratio() {
        let drive = |value: &str| {
            let (node, problems) = read(&format!(r#"{{"cloth": {{"drive": {value}}}}}"#));
            assert_eq!(problems, [""; 0], "{value}");
            node.cloth.and_then(|cloth| cloth.drive)
        };
        let of = |frequency: ClothMap, damping_ratio: f32| Some(ClothDrive { frequency, damping_ratio });
        assert_eq!(drive("4"), of(ClothMap::Uniform(4.0), 1.0));
        assert_eq!(drive("[0, 15]"), of(ClothMap::attribute("_CLOTH_DRIVE", 0.0, 15.0), 1.0));
        assert_eq!(drive("false"), of(ClothMap::Off, 1.0));
        let alpha = ClothMap::color(ClothColorChannel::A, 0.0, 4.0);
        assert_eq!(drive(r#"{"frequency": 4, "damping_ratio": 0.5, "map": "color.a"}"#), of(alpha, 0.5));
    }

    #[test]
    fn what_is_wrong_with_a_map_names_the_key_and_the_cure() {
        for (extras, key, what) in [
            (r#""max_distance": "far""#, "cloth.max_distance", "is `far`: it must be metres, [low, high]"),
            (r#""max_distance": true"#, "cloth.max_distance", "is a bool: it must be metres"),
            (r#""max_distance": [0, 0.1, 0.2]"#, "cloth.max_distance", "is a list, not of two numbers: it must be metres"),
            (r#""max_distance": {"map": "green"}"#, "cloth.max_distance.map", "is `green`: it must be `_NAME`"),
            (r#""max_distance": {"map": 1}"#, "cloth.max_distance.map", "is a number: it must be `_NAME`"),
            (r#""max_distance": {"hihg": 1}"#, "cloth.max_distance.hihg", "is not known: the keys are map, low, high"),
            (r#""max_distance": {"low": null}"#, "cloth.max_distance.low", "is null: it must be a number"),
            (r#""backstop": "yes""#, "cloth.backstop", "is `yes`: it must be metres, true"),
            (r#""backstop": {"distance": "far"}"#, "cloth.backstop.distance", "is `far`: it must be metres or [low, high]"),
            (r#""backstop": {"radius": []}"#, "cloth.backstop.radius", "is a list: it must be a number"),
            (r#""backstop": {"low": 0}"#, "cloth.backstop.low", "is not known: the keys are distance, radius, map"),
            (r#""drive": true"#, "cloth.drive", "is a bool: it must be hertz"),
            (r#""drive": {"damping_ratio": 1}"#, "cloth.drive.frequency", "is missing: it must be hertz"),
            (r#""drive": {"frequency": 4, "damping": 1}"#, "cloth.drive.damping", "is not known: the keys are frequency"),
        ] {
            let mut problems = Vec::new();
            let node = node(&format!(r#"{{"cloth": {{{extras}, "layer": 3}}}}"#), &mut problems);
            assert_eq!(node.cloth.and_then(|cloth| cloth.layer), Some(3), "{extras}: the rest does not work");
            assert_eq!(problems.len(), 1, "{extras}: {problems:?}");
            assert!(problems[0].key == key && problems[0].what.starts_with(what), "{extras}: {problems:?}");
        }
    }

    #[test]
    fn a_long_key_or_name_is_shortened() {
        let long = "k".repeat(20_000);
        let text = format!(
            "{{\"cloth\": {{\"{long}\": 1, \"material\": \"{long}\", \"pin\": \"{long}\", \"drive\": \"{long}\", \"backstop\": {{\"{long}\": 1}}}}}}"
        );
        let mut problems = Vec::new();
        let _ = node(&text, &mut problems);
        assert_eq!(problems.len(), 5);
        assert!(problems.iter().all(|problem| format!("{problem:?}").len() < 500), "{problems:?}");
    }

    #[test]
    fn each_wrong_or_unknown_key_is_one_problem_and_the_rest_still_works() {
        let (node, mut problems) = read(
            r#"{"cloth": {"material": "paper", "pin": {"a": 1}, "self_collision": "yes", "layer": 1.5, "thickness": "thin", "substep_rate": null,
                "stifness": 1}, "collider": {"shape": "donut", "frction": 1}}"#,
        );
        problems.sort();
        let expected = [
            "cloth.layer",
            "cloth.material",
            "cloth.pin",
            "cloth.self_collision",
            "cloth.stifness",
            "cloth.substep_rate",
            "cloth.thickness",
            "collider.frction",
            "collider.shape",
        ];
        assert_eq!(problems, expected);
        assert_eq!(node.cloth, Some(ClothExtras::default()));
        assert_eq!(read(r#"{"cloth": "yes"}"#).1, ["cloth"]);
        assert_eq!(
            read(r#"{"cloth": {"material": {"densty": 1, "drag": "much"}}}"#).1,
            ["cloth.material.densty", "cloth.material.drag"]
        );
    }

    #[test]
    fn scene_extras_are_vectors() {
        let mut problems = Vec::new();
        let read = scene(r#"{"gravity": [0, -1.62, 0], "wind": [1, 2]}"#, &mut problems);
        assert_eq!(read, SceneExtras { gravity: Some(Vec3::new(0.0, -1.62, 0.0)), wind: None });
        assert_eq!(problems.len(), 1);
    }
}
