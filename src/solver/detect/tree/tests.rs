//! The tree of crumpled cloths against all of their faces, one by one.

use std::collections::{BTreeMap, BTreeSet};

use fastrand::Rng;
use glam::{DVec3, Quat, Vec3, Vec4, vec3};

use super::*;
use crate::solver::detect::{PartRef, Surface};
use crate::solver::effort::Effort;
use crate::solver::scales::ALIGNED;
use crate::solver::scene::grid;
use crate::solver::topology::Topology;

/// Cosine by which what is told apart may be off for rounding (dimensionless).
const ROUNDING: f32 = 1.0e-4;

/// Pairs of faces, the smaller first.
type Pairs = BTreeSet<[u32; 2]>;
/// Vertices `[m]` and triangles.
type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// A rectangle of `columns` x `rows` vertices, of 1 m x 0.8 m.
fn sheet(columns: u32, rows: u32) -> Mesh {
    let mesh = grid(columns, rows, |u, v| vec3(u - 0.5, 0.8 * (v - 0.5), 0.0));
    (mesh.positions, mesh.triangles)
}

/// A sheet of 12 x 9 vertices that is cut from the border to its middle.
fn torn() -> Mesh {
    let (mut points, mut triangles) = sheet(12, 9);
    for i in 0..6 {
        let (vertex, copy) = (9 * i + 4, points.len() as u32);
        points.push(points[vertex as usize]);
        for triangle in &mut triangles {
            let above = triangle.iter().any(|v| points[*v as usize].y > 0.01);
            triangle.iter_mut().filter(|v| above && **v == vertex).for_each(|v| *v = copy);
        }
    }
    (points, triangles)
}

/// A sheet with a row of faces that stand on it.
fn finned() -> Mesh {
    let (mut points, mut triangles) = sheet(10, 8);
    for i in 2..7 {
        let (a, b) = (8 * i + 3, 8 * (i + 1) + 3);
        triangles.push([a, b, points.len() as u32]);
        points.push(0.5 * (points[a as usize] + points[b as usize]) + 0.1 * Vec3::Z);
    }
    (points, triangles)
}

/// Around one vertex, more faces than nodes are joined by.
fn fan() -> Mesh {
    let rim = |i: u32| Quat::from_rotation_z(i as f32 * std::f32::consts::TAU / 80.0) * (0.4 * Vec3::X);
    let points = [Vec3::ZERO].into_iter().chain((0..80).map(rim)).collect();
    (points, (0..80).map(|i| [0, 1 + i, 1 + (i + 1) % 80]).collect())
}

/// A ring of 60 x 4 vertices that is cut once, at an `angle` `[rad]`.
fn ring(angle: f32) -> Mesh {
    let mesh = grid(60, 4, |u, v| Quat::from_rotation_z(angle + 6.2 * u) * ((0.4 + 0.1 * v) * Vec3::X));
    (mesh.positions, mesh.triangles)
}

/// A tube of 10 x 8 vertices, so thin that small nodes go all around it.
fn tube() -> Mesh {
    let turn = |i: u32| Quat::from_rotation_y(i as f32 * std::f32::consts::TAU / 10.0);
    let points = (0..80).map(|k| turn(k / 8) * (0.06 * Vec3::X) + 0.1 * (k % 8) as f32 * Vec3::Y).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..10).flat_map(|i| (0..7).map(move |j| (i, j))) {
        let (a, b) = (8 * i + j, 8 * ((i + 1) % 10) + j);
        triangles.extend([[a, a + 1, b], [b, a + 1, b + 1]]);
    }
    (points, triangles)
}

/// Cloths and their tree.
struct Cloths {
    surface: Surface,
    positions: Vec<Vec4>,
    tree: Tree,
}

impl Cloths {
    fn new(parts: &[Mesh], self_collision: impl Fn(usize) -> bool) -> Self {
        let topologies: Vec<_> =
            parts.iter().map(|(points, faces)| Arc::new(Topology::new(points.len() as u32, faces.clone()))).collect();
        let part = |i: usize| PartRef {
            topology: &topologies[i],
            rest: &parts[i].0,
            garment_layer: 0,
            self_collision: self_collision(i),
            thickness: 0.01,
        };
        let parts: Vec<PartRef<'_>> = (0..parts.len()).map(part).collect();
        let surface = Surface::new(&parts).expect("cloths");
        let positions = surface.rest.iter().map(|x| x.extend(1.0)).collect();
        let mut cloths = Self { tree: Tree::of_surface(&surface), surface, positions };
        cloths.refit();
        cloths
    }

    /// One to three cloths, bent, creased and crumpled, some of which do not meet themselves.
    fn random(rng: &mut Rng) -> Self {
        let count = rng.usize(1..=3);
        let mut mesh = || match rng.u32(0..9) {
            0 => fan(),
            1 => finned(),
            2 => torn(),
            3 => ring(1.0),
            4 => tube(),
            _ => sheet(rng.u32(2..14), rng.u32(2..14)),
        };
        let parts: Vec<Mesh> = (0..count).map(|_| mesh()).collect();
        let alone = rng.usize(0..6);
        Self::new(&parts, |part| part != alone).crumpled(rng)
    }

    fn three_sheets(rng: &mut Rng) -> Self {
        Self::new(&[sheet(9, 7), sheet(8, 8), sheet(6, 9)], |_| true).crumpled(rng)
    }

    fn crumpled(mut self, rng: &mut Rng) -> Self {
        for part in self.surface.parts.clone() {
            self.crumple(&part.particles, rng);
        }
        self.refit();
        self
    }

    fn crumple(&mut self, particles: &Range<u32>, rng: &mut Rng) {
        let edge = self.surface.mean_edge;
        let mut axis = || 2.0 * rng.f32() - 1.0;
        let (turn, at) = (Quat::from_xyzw(axis(), axis(), axis(), axis()).normalize(), 0.2 * vec3(axis(), axis(), axis()));
        let (bend, wave) = (0.1 * axis(), 5.0 * axis());
        let creases = [(); 2].map(|()| (vec3(axis(), axis(), 0.0).normalize(), 0.4 * axis()));
        let creases = &creases[rng.usize(0..3)..];
        let rough = [0.0, 0.1, 0.3, 1.0][rng.usize(0..4)] * edge;
        for v in particles.clone() {
            let mut x = self.surface.rest[v as usize];
            for (k, &(normal, offset)) in (1..).zip(creases) {
                let beyond = normal.dot(x) - offset;
                if beyond > 0.0 {
                    x += -2.0 * beyond * normal + 0.2 * k as f32 * edge * Vec3::Z;
                }
            }
            x.z += bend * (wave * (x.x + 2.0 * x.y)).sin();
            let off = rough * (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5);
            self.positions[v as usize] = (turn * x + at + off).extend(1.0);
        }
    }

    fn refit(&mut self) {
        self.tree.refit(&self.surface, &self.positions, None);
    }

    fn corners(&self, face: u32) -> [Vec3A; 3] {
        self.surface.topology.faces[face as usize].map(|v| Vec3A::from_vec4(self.positions[v as usize]))
    }

    fn boxes(&self) -> Vec<Bounds> {
        (0..self.tree.len() as u32).map(|f| Bounds::around(self.corners(f).into_iter())).collect()
    }

    fn normal(&self, face: u32) -> Vec3A {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Whether two faces have a particle in common.
    fn share(&self, f: u32, g: u32) -> bool {
        let faces = &self.surface.topology.faces;
        faces[f as usize].iter().any(|v| faces[g as usize].contains(v))
    }

    /// Whether an edge of one face goes through the other.
    fn cross(&self, f: u32, g: u32) -> bool {
        let at = |f| self.corners(f).map(Vec3A::as_dvec3);
        let pierces = |t: [DVec3; 3], s: [DVec3; 3]| (0..3).any(|k| goes_through([t[k], t[(k + 1) % 3]], s));
        let (t, s) = (at(f), at(g));
        !self.share(f, g) && (pierces(t, s) || pierces(s, t))
    }

    /// Pairs whose boxes come within `margin` `[m]`, of cloths that may meet.
    fn close(&self, margin: f32) -> Pairs {
        let (boxes, margin) = (self.boxes(), Vec3A::splat(margin));
        let all = (0..boxes.len()).flat_map(|f| (0..f).map(move |g| [g, f]));
        let may = |[f, g]: [u32; 2]| {
            let parts = [f, g].map(|f| usize::from(self.surface.part_of_face(f)));
            parts[0] != parts[1] || self.surface.parts[parts[0]].self_collision
        };
        let close = all.filter(|&[f, g]| boxes[f].meets(&boxes[g], margin)).map(|pair| pair.map(|f| f as u32));
        close.filter(|&pair| may(pair)).collect()
    }

    fn found(&mut self, margin: f32) -> Pairs {
        let mut pairs = Pairs::new();
        let Self { surface, tree, .. } = self;
        tree.meetings(surface, margin, &Effort::UNBOUNDED.meter(), |tree, met| collect(surface, tree, met, &mut pairs));
        pairs
    }
}

/// Takes in the pairs of a meeting. None may come twice, and those of faces that share particles not as of faces that do not.
fn collect(surface: &Surface, tree: &Tree, met: &Meeting, pairs: &mut Pairs) {
    let faces = &surface.topology.faces;
    let mut count = 0;
    tree.pairs_of(met, |f, g| {
        assert!(f != g && pairs.insert([f.min(g), f.max(g)]), "{f} and {g}");
        let shares = faces[f as usize].iter().any(|v| faces[g as usize].contains(v));
        assert!(met.joined || !shares, "{f} and {g}");
        count += 1;
    });
    assert_eq!(count, met.count());
}

fn goes_through([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let around = [[a, b], [b, c], [c, a]].map(|[a, b]| volume(p, q, a, b));
    volume(a, b, c, p) * volume(a, b, c, q) < 0.0 && (around.iter().all(|v| *v > 0.0) || around.iter().all(|v| *v < 0.0))
}

/// Tells which pairs may be left out: those in one piece without slits whose normals all lie within 60° of one direction.
struct Flat<'a> {
    cloths: &'a Cloths,
    /// Places in [`TreeTopology::faces`] below each node, and the place of each face.
    below: Vec<Range<usize>>,
    place: Vec<usize>,
    known: BTreeMap<[u32; 2], bool>,
}

impl<'a> Flat<'a> {
    fn new(cloths: &'a Cloths) -> Self {
        let faces = &cloths.tree.topology.faces;
        let mut place = vec![0; faces.len()];
        faces.iter().enumerate().for_each(|(at, &f)| place[f as usize] = at);
        Self { cloths, below: below(&cloths.tree), place, known: BTreeMap::new() }
    }

    fn holds(&mut self, f: u32, g: u32) -> bool {
        let [above, others] = [f, g].map(|f| {
            let at = self.place[f as usize];
            (0..self.below.len() as u32).filter(|&i| self.below[i as usize].contains(&at)).collect::<Vec<_>>()
        });
        above.iter().any(|&a| others.iter().any(|&b| self.is_piece(a, b)))
    }

    /// Whether a node, or two that share particles, are such a piece.
    fn is_piece(&mut self, a: u32, b: u32) -> bool {
        if let Some(&known) = self.known.get(&[a, b]) {
            return known;
        }
        let Tree { topology, nodes, .. } = &self.cloths.tree;
        let (left, right) = (&nodes[a as usize], &nodes[b as usize]);
        let [mine, theirs] = [a, b].map(|i| &topology.faces[self.below[i as usize].clone()]);
        let is_whole = if a == b {
            left.disc
        } else {
            let (x, y) = (&self.below[a as usize], &self.below[b as usize]);
            let apart = x.end <= y.start || y.end <= x.start;
            let share = || mine.iter().any(|&f| theirs.iter().any(|&g| self.cloths.share(f, g)));
            left.smooth && right.smooth && apart && share()
        };
        let piece = is_whole && {
            let normals: Vec<Vec3A> = mine.iter().chain(theirs).map(|&f| self.cloths.normal(f)).collect();
            let around = Bounds::around(normals.iter().copied());
            let axes = [around.min + around.max, normals.iter().sum()];
            let near = |axis: Vec3A| normals.iter().all(|n| n.dot(axis) >= (ALIGNED - ROUNDING) * axis.length());
            axes.into_iter().any(near)
        };
        self.known.insert([a, b], piece);
        piece
    }
}

/// Where the faces below each node stand in [`TreeTopology::faces`].
fn below(tree: &Tree) -> Vec<Range<usize>> {
    let mut below = vec![0..0; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        below[i] = if node.right & IS_LEAF != 0 { node.run() } else { below[i + 1].start..below[node.right as usize].end };
    }
    below
}

fn random_margin(rng: &mut Rng, cloths: &Cloths) -> f32 {
    [0.0, 0.1, 0.5, 1.5][rng.usize(0..4)] * cloths.surface.mean_edge
}

#[test]
fn every_pair_of_faces_that_come_close_is_found_once_unless_it_lies_in_one_flat_piece() {
    let rng = &mut Rng::with_seed(1);
    let (mut met, mut flat, mut crossed) = (0, 0, 0);
    for round in 0..150 {
        let mut cloths = Cloths::random(rng);
        let margin = random_margin(rng, &cloths);
        let (found, close) = (cloths.found(margin), cloths.close(margin));
        assert!(found.is_subset(&close), "round {round}: {:?} are not close", found.difference(&close).next());
        let mut pieces = Flat::new(&cloths);
        for &[f, g] in close.difference(&found) {
            assert!(pieces.holds(f, g), "round {round}: {f} and {g} are close within {margin} m");
            assert!(!cloths.cross(f, g), "round {round}: {f} and {g} cross");
        }
        met += found.len();
        flat += close.len() - found.len();
        crossed += found.iter().filter(|&&[f, g]| cloths.cross(f, g)).count();
    }
    assert!(met > 100_000 && flat > 10_000 && crossed > 5_000, "{met} met, {flat} in flat pieces, {crossed} cross");
}

#[test]
fn of_marked_faces_those_pairs_are_found_that_have_one() {
    let rng = &mut Rng::with_seed(2);
    for share in [0.0, 0.02, 0.3, 1.0] {
        for _ in 0..15 {
            let mut cloths = Cloths::random(rng);
            let margin = random_margin(rng, &cloths);
            let marked: Vec<bool> = (0..cloths.tree.len()).map(|_| rng.f32() < share).collect();
            let all = cloths.found(margin);
            let expected: Pairs = all.iter().copied().filter(|pair| pair.iter().any(|f| marked[*f as usize])).collect();
            let Cloths { surface, tree, .. } = &mut cloths;
            let (mut pairs, meter) = (Pairs::new(), Effort::UNBOUNDED.meter());
            tree.mark(&marked);
            tree.meetings_with(surface, margin, &meter, |tree, met| collect(surface, tree, met, &mut pairs));
            assert!(pairs == expected, "{} of {} pairs with a share of {share}", pairs.len(), expected.len());
            assert_eq!(cloths.found(margin), all, "marks are gone");
        }
    }
}

#[test]
fn what_is_split_is_found_in_the_order_of_one_walk_for_as_many_visits() {
    let rng = &mut Rng::with_seed(7);
    let (mut found, mut most) = (0, 0);
    for round in 0..30 {
        let mut cloths = Cloths::random(rng);
        let margin = random_margin(rng, &cloths);
        let marked: Vec<bool> = (0..cloths.tree.len()).map(|_| rng.f32() < 0.1).collect();
        let Cloths { surface, tree, .. } = &mut cloths;
        tree.mark(&marked);
        for only_marked in [false, true] {
            let (mut expected, meter) = (Vec::new(), Effort::UNBOUNDED.meter());
            if only_marked {
                tree.meetings_with(surface, margin, &meter, |_, met| expected.push(*met));
            } else {
                tree.meetings(surface, margin, &meter, |_, met| expected.push(*met));
            }
            let (mut pairs, mut next, split) = (vec![(0, 0)], Vec::new(), Effort::UNBOUNDED.meter());
            tree.split(surface, margin, only_marked, 1 << (round % 9), &mut pairs, &mut next, &split);
            most = most.max(pairs.len());
            let mut meetings = Vec::new();
            while let Some(pair) = pairs.pop() {
                tree.meetings_of(surface, margin, only_marked, &mut vec![pair], &split, |_, met| meetings.push(*met));
            }
            assert!(meetings == expected, "round {round}: {} meetings, {} in one walk", meetings.len(), expected.len());
            assert_eq!(split.spent(), meter.spent());
            found += meetings.len();
        }
    }
    assert!(found > 1_000 && most > 256, "{found} meetings, of {most} pairs at most");
}

#[test]
fn what_is_walked_in_parts_has_the_pairs_of_one_walk() {
    let rng = &mut Rng::with_seed(3);
    let mut most = 0;
    for round in 0..30 {
        let mut cloths = Cloths::random(rng);
        let margin = random_margin(rng, &cloths);
        let (all, effort) = (cloths.found(margin), Effort::per_face(1, [1, 7, 60][round % 3]));
        for _ in 0..2 {
            let (mut pairs, mut parts) = (Pairs::new(), 0);
            loop {
                let Cloths { surface, tree, .. } = &mut cloths;
                let meter = effort.meter();
                let ends = tree.go_on(surface, margin, &meter, |tree, met| collect(surface, tree, met, &mut pairs));
                assert_eq!((ends[0], meter.is_spent() || ends[1]), (parts == 0, true), "part {parts}");
                parts += 1;
                if ends[1] {
                    break;
                }
                if parts > 1 {
                    continue;
                }
                // Other walks in between change nothing.
                assert_eq!(cloths.found(margin), all);
                cloths.tree.along(Vec3::ZERO, Vec3::X, |_| {});
            }
            assert!(pairs == all, "round {round}: {} of {} pairs in {parts} parts", pairs.len(), all.len());
            most = most.max(parts);
        }
    }
    assert!(most > 100, "{most} parts");
}

#[test]
fn a_walk_ends_where_its_effort_does() {
    let mut cloths = Cloths::three_sheets(&mut Rng::with_seed(4));
    let all = cloths.found(0.05);
    let Cloths { surface, tree, .. } = &mut cloths;
    let (mut pairs, meter) = (Pairs::new(), Effort::per_face(1, 40).meter());
    tree.meetings(surface, 0.05, &meter, |tree, met| collect(surface, tree, met, &mut pairs));
    assert_eq!(meter.spent(), 40);
    assert!(pairs.is_subset(&all) && pairs.len() < all.len(), "{} of {}", pairs.len(), all.len());
}

#[test]
fn a_flat_sheet_is_dismissed_at_its_root_and_a_bent_one_by_few_nodes() {
    let mut cloths = Cloths::new(&[sheet(40, 40)], |_| true);
    let mut look = || {
        cloths.refit();
        let (mut met, meter) = (0, Effort::UNBOUNDED.meter());
        cloths.tree.meetings(&cloths.surface, 0.001, &meter, |_, meeting| met += meeting.count());
        let (close, visits) = (cloths.close(0.001).len(), meter.spent());
        for (x, rest) in cloths.positions.iter_mut().zip(&cloths.surface.rest) {
            // Around half of a cylinder.
            let turn = Quat::from_rotation_y(3.0 * rest.x);
            *x = (turn * Vec3::Z / 3.0 + rest.y * Vec3::Y).extend(1.0);
        }
        (close, met, visits)
    };
    let (flat, bent) = (look(), look());
    assert!(flat.0 > 15_000 && flat.1 == 0 && flat.2 == 1, "{flat:?}");
    // Corners of boxes of faces across the border of two pieces touch.
    assert!(bent.0 > 15_000 && bent.1 < 200 && bent.2 < 400, "{bent:?}");
}

#[test]
fn a_cut_ring_that_slides_over_itself_is_not_taken_for_flat() {
    // Where the tree halves it, too: then the ends are in halves that share particles on the other side.
    for cut in [0.0, 0.5, 1.0, 1.5].map(|turn| turn * std::f32::consts::PI) {
        let mut cloths = Cloths::new(&[ring(cut)], |_| true);
        for (x, rest) in cloths.positions.iter_mut().zip(&cloths.surface.rest) {
            // Turned on by a tenth.
            let angle = (rest.y.atan2(rest.x) - cut + 1.0e-3).rem_euclid(std::f32::consts::TAU);
            *x = (Quat::from_rotation_z(0.1 * angle) * *rest).extend(1.0);
        }
        cloths.refit();
        let apart = |&[f, g]: &[u32; 2]| g - f > 40;
        let lies_on: Pairs = cloths.close(0.0).into_iter().filter(apart).collect();
        let missed = lies_on.difference(&cloths.found(0.0)).count();
        assert!(lies_on.len() > 50 && missed == 0, "{missed} of {} missed, cut at {cut}", lies_on.len());
    }
}

#[test]
fn a_disc_is_one_piece_without_a_hole() {
    let rng = &mut Rng::with_seed(5);
    let (mut discs, mut others) = (0, 0);
    for _ in 0..30 {
        let Cloths { tree, surface, .. } = Cloths::random(rng);
        for (node, run) in tree.nodes.iter().zip(below(&tree)) {
            let faces: BTreeSet<u32> = tree.topology.faces[run].iter().copied().collect();
            if !(node.disc || node.smooth) {
                others += usize::from(node.part != MIXED);
                continue;
            }
            let all = |of: &[[u32; 3]]| faces.iter().flat_map(|&f| of[f as usize]).collect::<BTreeSet<u32>>();
            let (vertices, edges) = (all(&surface.topology.faces), all(&surface.topology.face_edges));
            assert_eq!(vertices.len() + faces.len(), edges.len() + 1, "{faces:?}");
            let (mut reached, mut queue) = (BTreeSet::new(), vec![*faces.first().expect("a face")]);
            while let Some(f) = queue.pop() {
                if reached.insert(f) {
                    let edges = surface.topology.face_edges[f as usize];
                    let beside = edges.into_iter().flat_map(|e| surface.topology.edge_faces[e as usize]);
                    queue.extend(beside.filter(|g| faces.contains(g)));
                }
            }
            assert_eq!(reached, faces);
            discs += 1;
        }
    }
    assert!(discs > 500 && others > 50, "{discs} discs, {others} others");
}

#[test]
fn a_cloth_with_a_particle_that_is_nowhere_is_left_out_and_the_others_meet_as_before() {
    let rng = &mut Rng::with_seed(6);
    for nowhere in [f32::NAN, f32::INFINITY, 1.0e7] {
        let mut cloths = Cloths::three_sheets(rng);
        let (margin, path) = (0.02, (vec3(-1.0, -0.5, -0.3), vec3(2.0, 1.0, 0.6)));
        let all = cloths.found(margin);
        let out = cloths.surface.parts[1].clone();
        cloths.positions[out.particles.start as usize + 5].y = nowhere;
        cloths.refit();
        assert_eq!([0, 1, 2].map(|part| cloths.tree.is_quarantined(part)), [false, true, false]);
        let mut left = all;
        left.retain(|pair| !pair.iter().any(|f| out.faces.contains(f)));
        assert!(left.len() > 100, "{}", left.len());
        assert_eq!(cloths.found(margin), left);
        cloths.tree.along(path.0, path.1, |f| assert!(!out.faces.contains(&f)));
    }
}

#[test]
fn boxes_hold_all_faces_below_as_they_are_and_will_be_and_no_more() {
    let rng = &mut Rng::with_seed(7);
    for round in 0..20 {
        let mut cloths = Cloths::random(rng);
        let way = |rng: &mut Rng| 0.3 * (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5);
        let ahead: Vec<Vec3A> = cloths.positions.iter().map(|x| Vec3A::from(x.truncate() + way(rng))).collect();
        let looks = round % 2 == 0;
        let Cloths { surface, tree, positions } = &mut cloths;
        tree.refit(surface, positions, looks.then_some(&ahead));
        let mut boxes = cloths.boxes();
        for (own, face) in boxes.iter_mut().zip(&cloths.surface.topology.faces).filter(|_| looks) {
            *own = own.union(Bounds::around(face.iter().map(|&v| ahead[v as usize])));
        }
        let tree = &cloths.tree;
        for (node, run) in tree.nodes.iter().zip(below(tree)) {
            let faces = || tree.topology.faces[run.clone()].iter().map(|&f| boxes[f as usize]);
            assert_eq!(node.bounds, faces().fold(Bounds::EMPTY, Bounds::union));
            if node.right & IS_LEAF != 0 {
                let lanes: Vec<Bounds> = (0..LEAF).map(|lane| tree.packs[node.link as usize].get(lane)).collect();
                assert!(faces().chain([Bounds::EMPTY; LEAF]).take(LEAF).eq(lanes), "{:?}", tree.leaf(node.link).faces);
            }
        }
        assert_eq!(tree.boxes(u32::MAX).count(), tree.nodes.len());
        for depth in 0..5 {
            let shown: Vec<_> = tree.boxes(depth).collect();
            assert!(shown.iter().all(|(level, _)| *level <= depth));
            let sum = shown.iter().fold(Bounds::EMPTY, |sum, (_, own)| sum.union(*own));
            assert_eq!(sum, tree.nodes[0].bounds);
        }
    }
}

#[test]
fn a_leaf_is_folded_where_a_face_around_it_faces_back_and_nothing_above_it_is_flat() {
    let rng = &mut Rng::with_seed(8);
    let (mut folded, mut flat) = (0, 0);
    for _ in 0..40 {
        let cloths = Cloths::random(rng);
        let (tree, topology) = (&cloths.tree, &cloths.surface.topology);
        let below = below(tree);
        for leaf in &tree.topology.leaves {
            let node = &tree.nodes[leaf.node as usize];
            let own = &tree.topology.faces[node.run()];
            let touches = |f: u32, g: u32| {
                let shared = topology.faces[f as usize].iter().filter(|v| topology.faces[g as usize].contains(v));
                let shared: Vec<u32> = shared.copied().collect();
                shared.len() > 1 || shared.iter().any(|&v| topology.around(v).len() <= HUB)
            };
            let around = (0..tree.len() as u32).filter(|g| !own.contains(g) && own.iter().any(|&f| touches(f, *g)));
            let axis = own.iter().map(|&f| cloths.normal(f)).sum::<Vec3A>();
            let least = around.map(|g| cloths.normal(g).dot(axis)).fold(f32::INFINITY, f32::min);
            if least.abs() < ROUNDING {
                continue;
            }
            assert_eq!(node.folded, least < 0.0, "{own:?}: {least}");
            if node.folded {
                let mut above = tree.nodes.iter().zip(&below).filter(|(_, run)| run.contains(&node.run().start));
                assert!(above.all(|(above, _)| !above.normals.are_flat()));
            }
            *if node.folded { &mut folded } else { &mut flat } += 1;
        }
    }
    assert!(folded > 200 && flat > 200, "{folded} folded, {flat} not");
}

/// Whether a segment meets a box that is larger by `by` `[m]`: the part of it that is within, axis by axis.
fn meets(own: &Bounds, by: f64, from: Vec3, path: Vec3) -> bool {
    let (mut first, mut last) = (0.0f64, 1.0f64);
    (0..3).all(|k| {
        let (x, way) = (f64::from(from[k]), f64::from(path[k]));
        let (low, high) = (f64::from(own.min[k]) - by - x, f64::from(own.max[k]) + by - x);
        if way == 0.0 {
            return low <= 0.0 && high >= 0.0;
        }
        first = first.max((low / way).min(high / way));
        last = last.min((low / way).max(high / way));
        first <= last
    })
}

#[test]
fn along_a_segment_every_face_is_found_once_whose_box_it_meets() {
    let rng = &mut Rng::with_seed(9);
    let (mut met, mut pierced) = (0, 0);
    for _ in 0..50 {
        let mut cloths = Cloths::random(rng);
        let boxes = cloths.boxes();
        for k in 0..40 {
            let mut point = || 1.4 * (vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5);
            let (from, to) = (point(), point());
            // Along an axis, in a plane across one, and without a length, too.
            let path = (to - from) * [Vec3::ONE, Vec3::X, vec3(0.0, 1.0, 1.0), Vec3::ZERO][k % 4];
            let mut found = BTreeSet::new();
            cloths.tree.along(from, path, |f| assert!(found.insert(f), "{f}"));
            for (f, own) in (0..).zip(&boxes) {
                let is_found = found.contains(&f);
                assert!(is_found || !meets(own, 0.0, from, path), "{f}: {own:?}, {from} {path}");
                assert!(!is_found || meets(own, 1.0e-4, from, path), "{f}: {own:?}, {from} {path}");
                let segment = [from, from + path].map(Vec3::as_dvec3);
                let pierces = goes_through(segment, cloths.corners(f).map(Vec3A::as_dvec3));
                assert!(is_found || !pierces, "{f}");
                pierced += usize::from(pierces);
            }
            met += found.len();
        }
    }
    assert!(met > 2_000 && pierced > 300, "{met} met, {pierced} pierced");
}
