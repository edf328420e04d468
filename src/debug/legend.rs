//! What the colours mean.

use bevy::prelude::*;

use super::{ClothDebug, scale};
use crate::solver::resolve::ContourKind;

/// A colour and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendLine {
    /// The item of [`ClothDebug`], such as `"springs"`.
    pub item: &'static str,
    /// What has the colour, with its unit, such as `"+5 %"`.
    pub label: String,
    /// The colour.
    pub color: Color,
}

impl ClothDebug {
    /// What the colours of the items mean that are drawn, in the order of the frame: for a panel of your own, a line each.
    #[must_use]
    pub fn legend(&self) -> Vec<LegendLine> {
        let mut lines = Vec::new();
        let mut add = |shown: bool, item: &'static str, entries: &[(String, Color)]| {
            if shown {
                lines.extend(entries.iter().map(|(label, color)| LegendLine { item, label: label.clone(), color: *color }));
            }
        };
        let percent = (1.0e5 * super::springs::full_scale(self.strain)).round() / 1.0e3;
        let says = |text: &str, color| (text.to_string(), color);
        add(self.pins, "pins", &[says("held firmly", scale::sequential(1.0)), says("hardly held", scale::sequential(0.0))]);
        let reaches =
            [says("held on the skin", scale::sequential(0.0)), says("farthest of this cloth", scale::sequential(1.0))];
        add(self.maps, "maps", &reaches);
        let used =
            [says("at its place on the skin", scale::sequential(0.0)), says("as far as it may be", scale::sequential(1.0))];
        add(self.targets, "targets", &used);
        add(self.wind, "wind", &[says("still air", scale::sequential(0.0)), says("20 m/s", scale::sequential(1.0))]);
        add(
            self.springs,
            "springs",
            &[
                (format!("-{percent} % or less"), scale::diverging(-1.0)),
                says("length at rest", scale::diverging(0.0)),
                (format!("+{percent} % or more"), scale::diverging(1.0)),
            ],
        );
        let forces = [("0.1 mN or less", 1.0e-4), ("10 mN", 1.0e-2), ("1 N or more", 1.0)];
        add(self.contacts, "contacts", &forces.map(|(text, n)| says(text, scale::sequential(scale::force(n)))));
        let levels: Vec<_> = (0..=self.bvh_levels.min(32)).map(|n| (format!("level {n}"), scale::number(n))).collect();
        add(self.bvh, "bvh", &levels);
        let kinds = KINDS.map(|(text, kind)| says(text, scale::contour(kind)));
        add(self.crossings && !self.contours, "crossings", &kinds);
        add(self.contours, "contours", &kinds);
        add(self.regions && !self.contours && !self.crossings, "regions", &kinds);
        add(self.sleep, "sleep", &super::sleep::Rest::ALL.map(|rest| says(rest.label(), rest.color())));
        add(self.normals, "normals", &[says("normal", super::normals::COLOR)]);
        add(self.bounds, "bounds", &[says("box for culling", super::bounds::COLOR)]);
        lines
    }
}

/// How contours end, in words.
const KINDS: [(&str, ContourKind); 8] = [
    ("closed: no ends", ContourKind::Closed),
    ("eight: both ends in one loop vertex", ContourKind::Eight),
    ("LL: in two loop vertices", ContourKind::Ll),
    ("BBII: on two borders of one sheet", ContourKind::Bbii),
    ("BIBI: on a border of each sheet", ContourKind::Bibi),
    ("BLI: in a loop vertex and on a border", ContourKind::Bli),
    ("cross: two borders, a loop vertex between", ContourKind::Cross),
    ("anything else", ContourKind::Unknown),
];
