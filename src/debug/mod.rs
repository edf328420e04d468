//! Debug drawing of what the solver sees, as gizmos: one file per item.
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_drape::{prelude::*, debug::*};
//! # fn add(app: &mut App) {
//! app.add_plugins(ClothDebugPlugin).insert_resource(ClothDebug { springs: true, ..default() });
//! # }
//! ```
//!
//! Everything is drawn where the solver has it: a cloth whose last clean shape is held is drawn where it really is.
//! [`ClothDebug::legend`] says what the colours mean. Width of lines, layers and whether they are hidden by what is in front
//! are set as for any gizmos, in the group [`ClothGizmos`].
//!
//! | item | after | drawn |
//! |---|---|---|
//! | [`pins`](ClothDebug::pins) | Prepare | where each held particle is and where it is held, by weight |
//! | [`maps`](ClothDebug::maps) | Prepare | edges on the skin, by how far cloth may be from it there |
//! | [`targets`](ClothDebug::targets) | Prepare | from each particle to its place on the skin, by the share that it takes of its maximum distance |
//! | [`wind`](ClothDebug::wind) | Prepare | velocity of the air at triangles, by speed |
//! | [`springs`](ClothDebug::springs) | Integrate | edges, by strain |
//! | [`contacts`](ClothDebug::contacts) | Integrate | where cloth touches cloth and bodies, by force |
//! | [`bvh`](ClothDebug::bvh) | Detect | boxes of the search tree, by level |
//! | [`crossings`](ClothDebug::crossings), [`contours`](ClothDebug::contours), [`regions`](ClothDebug::regions) | Evaluate | what is still tangled, by how its contour ends |
//! | [`sleep`](ClothDebug::sleep) | Respond | borders, by level of detail: strained, awake, settling, fewer substeps, still or asleep |
//! | [`normals`](ClothDebug::normals), [`bounds`](ClothDebug::bounds) | Sync | normals of particles, boxes for culling |

mod bounds;
mod bvh;
mod contacts;
mod contours;
mod legend;
mod maps;
mod normals;
mod pins;
mod regions;
mod scale;
mod sleep;
mod springs;
mod targets;
mod wind;

pub use legend::LegendLine;
pub use scale::contour as contour_color;

use bevy::gizmos::GizmoAsset;
use bevy::gizmos::config::GizmoLineConfig;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::schedule;
use crate::solver::rest::RestShape;
use crate::solver::topology::NONE;

/// Draws what the solver sees, as [`ClothDebug`] says. Without it nothing is kept for drawing and nothing is spent on it.
///
/// # Panics
/// Without [`ClothPlugin`](crate::ClothPlugin), or without Bevy's `GizmoPlugin`, which is part of `DefaultPlugins`.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothDebugPlugin;

/// Gizmos of cloth: the group in the `GizmoConfigStore` under which their width, layers and depth are set. Lines are 1.5 px
/// wide and slightly in front of what they lie on.
#[derive(Clone, Copy, Debug, Default, Reflect, GizmoConfigGroup)]
#[reflect(Default, Clone, Debug)]
pub struct ClothGizmos;

/// Which gizmos are drawn of all cloths, and on which scale.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothDebug {
    /// A cross at each particle that is held, and a line to where. Default true.
    pub pins: bool,
    /// Edges where the skin is, by how far cloth may be from it: the map of
    /// [`ClothLimits::max_distance`](crate::ClothLimits::max_distance). Default false.
    pub maps: bool,
    /// A line from each particle to its place on the skin, by the share that it takes of its maximum distance. Default false.
    pub targets: bool,
    /// Arrows along the velocity of the air at triangles, at most [`arrows`](Self::arrows) on each cloth. Default false.
    pub wind: bool,
    /// Every edge, by its strain. Default false.
    pub springs: bool,
    /// Contacts of cloth with cloth, with itself and with bodies, by force. Default true.
    pub contacts: bool,
    /// Boxes of the search tree, down to [`bvh_levels`](Self::bvh_levels). Default false.
    pub bvh: bool,
    /// A cross where an edge goes through a face. Default true.
    pub crossings: bool,
    /// Intersection curves, by how they end. Default true.
    pub contours: bool,
    /// The pieces that contours cut off. Default false.
    pub regions: bool,
    /// The border of each cloth, by its level of detail: strained, awake, settling, half or a quarter of the substeps, still,
    /// or asleep. A cloth without a border has every edge drawn. Default false.
    pub sleep: bool,
    /// Normals of the particles. Default false.
    pub normals: bool,
    /// The box of each cloth by which cameras cull it. Default false.
    pub bounds: bool,

    /// Strain at the ends of the colours of [`springs`](Self::springs) (dimensionless). Default 0.05, range 1e-4 to 10.
    pub strain: f32,
    /// Levels of boxes below the root. Default 4, range 0 to 32.
    pub bvh_levels: u32,
    /// Length of lines at contacts and of normals `[m]`. Default 0.03, range 0 to 100.
    pub length: f32,
    /// Length of an arrow for each metre per second of wind `[s]`. Default 0.03, range 0 to 100.
    pub wind_scale: f32,
    /// Most arrows on a cloth. Default 200, range 1 to 100,000.
    pub arrows: u32,
}

impl Default for ClothDebug {
    fn default() -> Self {
        Self {
            pins: true,
            contacts: true,
            crossings: true,
            contours: true,
            strain: 0.05,
            bvh_levels: 4,
            length: 0.03,
            wind_scale: 0.03,
            arrows: 200,
            ..Self::OFF
        }
    }
}

impl ClothDebug {
    const OFF: Self = Self {
        pins: false,
        maps: false,
        targets: false,
        wind: false,
        springs: false,
        contacts: false,
        bvh: false,
        crossings: false,
        contours: false,
        regions: false,
        sleep: false,
        normals: false,
        bounds: false,
        strain: 0.0,
        bvh_levels: 0,
        length: 0.0,
        wind_scale: 0.0,
        arrows: 0,
    };

    /// Names of all items, in the order of the frame.
    pub const ITEMS: [&str; 13] = [
        "pins",
        "maps",
        "targets",
        "wind",
        "springs",
        "contacts",
        "bvh",
        "crossings",
        "contours",
        "regions",
        "sleep",
        "normals",
        "bounds",
    ];

    /// Draws nothing; scales as by default.
    #[must_use]
    pub fn none() -> Self {
        let Self { strain, bvh_levels, length, wind_scale, arrows, .. } = Self::default();
        Self { strain, bvh_levels, length, wind_scale, arrows, ..Self::OFF }
    }

    /// Draws only the items named; names that are not known are left out.
    #[must_use]
    pub fn only<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut only = Self::none();
        for name in names {
            if let Some(item) = only.item_mut(name) {
                *item = true;
            }
        }
        only
    }

    /// Whether an item is drawn, by its name.
    #[must_use]
    pub fn item_mut(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "pins" => &mut self.pins,
            "maps" => &mut self.maps,
            "targets" => &mut self.targets,
            "wind" => &mut self.wind,
            "springs" => &mut self.springs,
            "contacts" => &mut self.contacts,
            "bvh" => &mut self.bvh,
            "crossings" => &mut self.crossings,
            "contours" => &mut self.contours,
            "regions" => &mut self.regions,
            "sleep" => &mut self.sleep,
            "normals" => &mut self.normals,
            "bounds" => &mut self.bounds,
            _ => return None,
        })
    }
}

impl Plugin for ClothDebugPlugin {
    fn build(&self, app: &mut App) {
        let config = GizmoConfig { line: GizmoLineConfig { width: 1.5, ..default() }, depth_bias: -0.002, ..default() };
        app.init_resource::<ClothDebug>().init_resource::<contacts::Touched>().insert_gizmo_config(ClothGizmos, config);
    }

    fn finish(&self, app: &mut App) {
        assert!(
            app.world().contains_resource::<Assets<GizmoAsset>>(),
            "ClothDebugPlugin needs gizmos. Add `DefaultPlugins`, or for a headless app `app.add_plugins(GizmoPlugin)`."
        );
        schedule::after_integrate(app, contacts::remember.run_if(|debug: Res<ClothDebug>| debug.contacts));
        schedule::after_sync(
            app,
            (
                pins::draw.run_if(|debug: Res<ClothDebug>| debug.pins),
                maps::draw.run_if(|debug: Res<ClothDebug>| debug.maps),
                targets::draw.run_if(|debug: Res<ClothDebug>| debug.targets),
                wind::draw.run_if(|debug: Res<ClothDebug>| debug.wind),
                springs::draw.run_if(|debug: Res<ClothDebug>| debug.springs),
                contacts::draw.run_if(|debug: Res<ClothDebug>| debug.contacts),
                bvh::draw.run_if(|debug: Res<ClothDebug>| debug.bvh),
                contours::draw.run_if(|debug: Res<ClothDebug>| debug.contours || debug.crossings),
                regions::draw.run_if(|debug: Res<ClothDebug>| debug.regions),
                sleep::draw.run_if(|debug: Res<ClothDebug>| debug.sleep),
                normals::draw.run_if(|debug: Res<ClothDebug>| debug.normals),
                bounds::draw.run_if(|debug: Res<ClothDebug>| debug.bounds),
            ),
        );
    }
}

/// The edges at the border of a shape; all of one that has none.
pub(crate) fn border(rest: &RestShape) -> impl Iterator<Item = [u32; 2]> + '_ {
    let topology = &rest.topology;
    let closed = !topology.edge_faces.iter().any(|faces| faces.contains(&NONE));
    let edges = topology.edges.iter().zip(&topology.edge_faces);
    edges.filter(move |(_, faces)| closed || faces.contains(&NONE)).map(|(edge, _)| *edge)
}

/// A point of a frame of simulation in the world, as gizmos want it `[m]`.
pub(crate) fn place(origin: DVec3, point: Vec3) -> Vec3 {
    (origin + point.as_dvec3()).as_vec3()
}
