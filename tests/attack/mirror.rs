//! Every component of the plugin, without naming any: made, changed, put in and taken out through reflection.

use bevy::ecs::reflect::{ReflectComponent, ReflectResource};
use bevy::prelude::*;
use bevy::reflect::enums::{DynamicEnum, DynamicVariant, VariantInfo};
use bevy::reflect::structs::DynamicStruct;
use bevy::reflect::tuple::DynamicTuple;
use bevy::reflect::{PartialReflect, ReflectMut, ReflectRef, TypeRegistry};
use fastrand::Rng;

use super::wild::{number, once_in, span};

/// What the plugin writes and nobody should: put in with its defaults only.
const READ_ONLY: [&str; 6] = ["ClothBuildReport", "ClothContacts", "ClothError", "ClothReaction", "ClothReport", "ClothStatus"];

/// A component that can be put in.
#[derive(Clone)]
pub struct Kind {
    /// Its short name.
    pub name: String,
    component: ReflectComponent,
    default: ReflectDefault,
}

/// Those of the plugin, in the order of their names.
pub fn kinds(world: &World) -> Vec<Kind> {
    let registry = world.resource::<AppTypeRegistry>().read();
    let ours = registry.iter().filter(|r| r.type_info().type_path().starts_with("bevy_drape::"));
    let mut kinds: Vec<Kind> = ours
        .filter_map(|r| {
            let name = r.type_info().type_path_table().short_path().to_owned();
            if r.data::<ReflectResource>().is_some() {
                return None;
            }
            // Any length of a mesh of any size: that comes in with the mesh.
            if ["ClothSubdivision", "ClothDecimation"].contains(&name.as_str()) {
                return None;
            }
            let component = r.data::<ReflectComponent>()?.clone();
            Some(Kind { name, component, default: r.data::<ReflectDefault>()?.clone() })
        })
        .collect();
    kinds.sort_by(|a, b| a.name.cmp(&b.name));
    kinds
}

/// How much of a value is changed.
#[derive(Clone, Copy)]
pub struct Wildness {
    /// Once in so many numbers.
    pub once_in: u32,
    /// Whether to numbers that nobody should set.
    pub wildly: bool,
    /// What entities become.
    pub entity: Entity,
}

/// Puts a component in, with some of its defaults changed.
pub fn put(world: &mut World, entity: Entity, kind: &Kind, how: Wildness, rng: &mut Rng) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let mut value = kind.default.default();
    if !READ_ONLY.contains(&kind.name.as_str()) {
        change(value.as_partial_reflect_mut(), &registry, how, rng);
    }
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        kind.component.insert(&mut entity, value.as_partial_reflect(), &registry);
    }
}

/// Takes a component out.
pub fn take(world: &mut World, entity: Entity, kind: &Kind) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        kind.component.remove(&mut entity);
    }
}

/// Changes something in a component that is there; whether there was one.
pub fn poke(world: &mut World, entity: Entity, kind: &Kind, how: Wildness, rng: &mut Rng) -> bool {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let Ok(mut entity) = world.get_entity_mut(entity) else { return false };
    if READ_ONLY.contains(&kind.name.as_str()) {
        return false;
    }
    let Some(mut value) = kind.component.reflect_mut(&mut entity) else { return false };
    change(value.as_partial_reflect_mut(), &registry, how, rng);
    true
}

/// Changes numbers, switches, entities and variants in a value.
pub fn change(value: &mut dyn PartialReflect, registry: &TypeRegistry, how: Wildness, rng: &mut Rng) {
    let hit = once_in(rng, how.once_in);
    if let Some(x) = value.try_downcast_mut::<f32>() {
        if hit {
            *x = if how.wildly { number(rng) } else { (*x).clamp(-1.0e6, 1.0e6) * span(rng, 0.5, 2.0) };
        }
    } else if let Some(x) = value.try_downcast_mut::<u32>() {
        if hit {
            *x = if how.wildly && rng.bool() { rng.u32(..) } else { rng.u32(0..5) };
        }
    } else if let Some(x) = value.try_downcast_mut::<i32>() {
        if hit {
            *x = if how.wildly { rng.i32(..) } else { rng.i32(-2..3) };
        }
    } else if let Some(x) = value.try_downcast_mut::<bool>() {
        *x ^= hit;
    } else if let Some(x) = value.try_downcast_mut::<Entity>() {
        *x = how.entity;
    } else {
        if hit {
            switch(value, registry, rng);
        }
        parts(value, &mut |part| change(part, registry, how, rng));
    }
}

/// Calls `f` with each part of a value.
fn parts(value: &mut dyn PartialReflect, f: &mut dyn FnMut(&mut dyn PartialReflect)) {
    match value.reflect_mut() {
        ReflectMut::Struct(s) => (0..s.field_len()).for_each(|i| s.field_at_mut(i).into_iter().for_each(&mut *f)),
        ReflectMut::TupleStruct(s) => (0..s.field_len()).for_each(|i| s.field_mut(i).into_iter().for_each(&mut *f)),
        ReflectMut::Tuple(t) => (0..t.field_len()).for_each(|i| t.field_mut(i).into_iter().for_each(&mut *f)),
        ReflectMut::List(l) => (0..l.len()).for_each(|i| l.get_mut(i).into_iter().for_each(&mut *f)),
        ReflectMut::Array(a) => (0..a.len()).for_each(|i| a.get_mut(i).into_iter().for_each(&mut *f)),
        ReflectMut::Enum(e) => (0..e.field_len()).for_each(|i| e.field_at_mut(i).into_iter().for_each(&mut *f)),
        _ => {}
    }
}

/// Makes an enum another of its variants, with defaults in it.
fn switch(value: &mut dyn PartialReflect, registry: &TypeRegistry, rng: &mut Rng) {
    let ReflectMut::Enum(as_enum) = value.reflect_mut() else { return };
    let Some(info) = as_enum.get_represented_enum_info() else { return };
    let Some(variant) = info.variant_at(rng.usize(0..info.variant_len())) else { return };
    let made = |id| registry.get_type_data::<ReflectDefault>(id).map(|d| d.default().into_partial_reflect());
    let fields = match variant {
        VariantInfo::Unit(_) => DynamicVariant::Unit,
        VariantInfo::Tuple(fields) => {
            let mut tuple = DynamicTuple::default();
            for field in fields.iter() {
                let Some(value) = made(field.type_id()) else { return };
                tuple.insert_boxed(value);
            }
            DynamicVariant::Tuple(tuple)
        }
        VariantInfo::Struct(fields) => {
            let mut named = DynamicStruct::default();
            for field in fields.iter() {
                let Some(value) = made(field.type_id()) else { return };
                named.insert_boxed(field.name(), value);
            }
            DynamicVariant::Struct(named)
        }
    };
    // What cannot be made from its defaults stays as it is.
    let _ = value.try_apply(&DynamicEnum::new(variant.name(), fields));
}

/// The first number in a value that is not finite, by its path.
pub fn not_finite(value: &dyn PartialReflect, path: &str) -> Option<String> {
    if let Some(x) = value.try_downcast_ref::<f32>() {
        return (!x.is_finite()).then(|| format!("{path} = {x}"));
    }
    let named = |name: &str, part: Option<&dyn PartialReflect>| not_finite(part?, &format!("{path}.{name}"));
    let numbered = |i: usize, part: Option<&dyn PartialReflect>| not_finite(part?, &format!("{path}.{i}"));
    match value.reflect_ref() {
        ReflectRef::Struct(s) => (0..s.field_len()).find_map(|i| named(s.name_at(i).unwrap_or("?"), s.field_at(i))),
        ReflectRef::TupleStruct(s) => (0..s.field_len()).find_map(|i| numbered(i, s.field(i))),
        ReflectRef::Tuple(t) => (0..t.field_len()).find_map(|i| numbered(i, t.field(i))),
        ReflectRef::List(l) => (0..l.len()).find_map(|i| numbered(i, l.get(i))),
        ReflectRef::Array(a) => (0..a.len()).find_map(|i| numbered(i, a.get(i))),
        ReflectRef::Enum(e) => (0..e.field_len()).find_map(|i| numbered(i, e.field_at(i))),
        _ => None,
    }
}
