//! The drape test of the fabric that is tuned: a specimen in the panel, beside the scene and apart from its wind, bodies and
//! clock.

use bevy::math::{Mat3, Vec3};
use bevy_egui::egui::{Color32, Mesh, Painter, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use super::widgets::button;
use crate::components::ClothMaterial;
use crate::lab::drape::{self, DISK, Drape, Run, SPECIMEN};
use crate::lab::{FRAME_RATE, SAMPLES, Settling};
use crate::solver::scene::Scene;
use crate::solver::settings::Fabric;

/// Edges of the specimen `[m]`: the coarsest that shows the nodes of every preset, in about half a millisecond a frame.
const EDGE: f32 = 0.01;
/// Height of a view `[points]`.
const HEIGHT: f32 = 150.0;
/// How far the view from aside looks down `[rad]`.
const PITCH: f32 = 0.5;
/// Triangles of the disk as it is drawn.
const CORNERS: u32 = 48;

const TIP: &str = "Cusick's test (BS 5058): a round specimen of 30 cm on a disk of 18 cm. The drape coefficient is how much of the overhang its shadow from above covers: 100 % is a board, 0 % hangs straight down. \
     Nodes are its folds. It starts again when the material changes.";

/// A specimen, while one was asked for.
#[derive(Default)]
pub(super) struct Specimen {
    test: Option<Test>,
}

struct Test {
    fabric: Fabric,
    scene: Scene,
    settling: Settling,
    /// What it showed once it lay still.
    result: Option<Drape>,
}

impl Test {
    fn new(fabric: Fabric) -> Self {
        let scene = drape::scene(&drape::rings(EDGE), &fabric, Run::new(EDGE));
        Self { fabric, scene, settling: Settling::default(), result: None }
    }

    fn step(&mut self) {
        let longest = Run::new(EDGE).longest;
        if self.result.is_none() && (self.settling.step(&mut self.scene, 1.0 / FRAME_RATE) || self.scene.time >= longest) {
            self.result = Some(drape::judge(&self.scene));
        }
    }
}

impl Specimen {
    /// Draws the button and, while it is pressed, the specimen, a frame later than before.
    pub(super) fn show(&mut self, ui: &mut Ui, material: &ClothMaterial) {
        let (text, asked) = if self.test.is_some() { ("put the disk away", false) } else { ("drape on a disk", true) };
        if button(ui, text, text, TIP) {
            self.test = asked.then(|| Test::new(material.to_fabric()));
        }
        let Some(test) = &mut self.test else { return };
        let fabric = material.to_fabric();
        if test.fabric != fabric {
            *test = Test::new(fabric);
        }
        test.step();
        if test.result.is_none() {
            ui.ctx().request_repaint();
        }
        let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
        ui.horizontal(|ui| {
            for view in
                [Mat3::from_rotation_x(PITCH) * Mat3::from_rotation_y(0.6), Mat3::from_rotation_x(core::f32::consts::FRAC_PI_2)]
            {
                let (response, painter) = ui.allocate_painter(vec2(width, HEIGHT), Sense::hover());
                draw(&painter, response.rect, &test.scene, view);
                response.on_hover_text(TIP);
            }
        });
        ui.label(text_of(test.result, material)).on_hover_text(TIP);
    }
}

/// What a specimen shows, and what the preset is to show whose material it has.
fn text_of(result: Option<Drape>, material: &ClothMaterial) -> String {
    let Some(Drape { coefficient, nodes }) = result else { return "drape coefficient: it still moves".into() };
    let preset = ClothMaterial::PRESETS.into_iter().find(|(_, preset)| preset == material);
    let sample = preset.and_then(|(name, _)| SAMPLES.into_iter().find(|sample| sample.name == name));
    let asked = sample.map(|sample| format!("; {} shows {} ± {}", sample.name, sample.drape, sample.within));
    format!("drape coefficient {coefficient:.0} %, {nodes} nodes{}", asked.unwrap_or_default())
}

/// Draws the disk and the cloth on it, far triangles first, as `view` turns them: `x` to the right, `y` up, `z` towards the
/// eye.
fn draw(painter: &Painter, rect: Rect, scene: &Scene, view: Mat3) {
    let scale = 0.5 * rect.width().min(1.3 * rect.height()) / (1.05 * SPECIMEN);
    // What overhangs hangs below the disk.
    let middle = view * Vec3::new(0.0, -0.4 * (SPECIMEN - DISK), 0.0);
    let at = |x: Vec3| {
        let x = x - middle;
        pos2(rect.center().x + scale * x.x, rect.center().y - scale * x.y)
    };
    painter.rect_filled(rect, 4.0, Color32::from_gray(30));
    let rim = (0..CORNERS).map(|k| {
        let (sin, cos) = (core::f32::consts::TAU * k as f32 / CORNERS as f32).sin_cos();
        at(view * Vec3::new(DISK * cos, -0.002, DISK * sin))
    });
    painter.add(Shape::convex_polygon(rim.collect(), Color32::from_gray(80), Stroke::NONE));
    let cloth = &scene.cloths[0];
    let points: Vec<Vec3> = cloth.sim.state.positions.iter().map(|x| view * x.truncate()).collect();
    let faces = &cloth.rest.topology.faces;
    let mut normals = vec![Vec3::ZERO; points.len()];
    for face in faces {
        let [a, b, c] = face.map(|p| points[p as usize]);
        let normal = (b - a).cross(c - a);
        face.iter().for_each(|&p| normals[p as usize] += normal);
    }
    let light = view * Vec3::new(-0.5, 0.8, 0.3).normalize();
    let mut mesh = Mesh::default();
    for (x, normal) in points.iter().zip(&normals) {
        let lit = normal.normalize_or_zero().dot(light).abs();
        let shade = |full: f32| (full * (0.25 + 0.75 * lit)) as u8;
        mesh.colored_vertex(at(*x), Color32::from_rgb(shade(200.0), shade(170.0), shade(130.0)));
    }
    let depth = |face: &[u32; 3]| face.iter().map(|&p| points[p as usize].z).sum::<f32>();
    let mut order: Vec<&[u32; 3]> = faces.iter().collect();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    order.iter().for_each(|[a, b, c]| mesh.add_triangle(*a, *b, *c));
    painter.add(Shape::mesh(mesh));
}
