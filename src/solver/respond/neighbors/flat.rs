//! Where the cloth hardly bends: faces of one fan are hardly closer there than at rest.

use glam::{Vec3A, Vec4};

use crate::solver::detect::Surface;
use crate::solver::scales::ALIGNED;
use crate::solver::topology::NONE;

/// Asked for more than one in this many particles, it is cheaper to find out about all.
const ONE_IN: usize = 64;

/// Where the cloth hardly bends: particles around which all normals lie, and will lie, within 60° of their sum. Distances
/// across a crease are at least half of those at rest there.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Flatness {
    /// Normals of faces as long as twice their area `[m²]`, and their sums around particles.
    normals: Vec<Vec3A>,
    sums: Vec<Vec3A>,
    /// Whether particles are flat; none where it was not asked for since everything moved.
    flat: Vec<Option<bool>>,
    /// Particles for which it was.
    asked: u32,
}

impl Flatness {
    pub(super) fn new(surface: &Surface) -> Self {
        let n = surface.len();
        let normals = vec![Vec3A::ZERO; surface.topology.faces.len()];
        Self { normals, sums: vec![Vec3A::ZERO; n], flat: vec![None; n], asked: 0 }
    }

    /// Everything moved: nothing is known.
    pub(super) fn forget(&mut self) {
        self.asked = 0;
        self.flat.fill(None);
    }

    /// Whether particle `v` is flat.
    #[inline]
    pub(super) fn holds(&mut self, v: u32, surface: &Surface, positions: &[Vec4], ahead: &[Vec3A]) -> bool {
        self.flat[v as usize].unwrap_or_else(|| self.find(v, surface, positions, ahead))
    }

    /// Finds out about particle `v`, or about all when that was asked [often](ONE_IN).
    #[cold]
    fn find(&mut self, v: u32, surface: &Surface, positions: &[Vec4], ahead: &[Vec3A]) -> bool {
        let now = |v: u32| Vec3A::from_vec4(positions[v as usize]);
        let then = |v: u32| ahead[v as usize];
        self.asked += 1;
        if self.asked as usize * ONE_IN <= self.flat.len() {
            let flat = is_flat(v, surface, now) && is_flat(v, surface, then);
            self.flat[v as usize] = Some(flat);
            return flat;
        }
        self.flat.fill(Some(true));
        self.keep(surface, now);
        self.keep(surface, then);
        self.flat[v as usize] == Some(true)
    }

    fn keep(&mut self, surface: &Surface, at: impl Fn(u32) -> Vec3A) {
        let Self { normals, sums, flat, .. } = self;
        sums.fill(Vec3A::ZERO);
        // Any direction will do, so large faces may count for more.
        for (&[a, b, c], normal) in surface.topology.faces.iter().zip(normals.iter_mut()) {
            let origin = at(a);
            *normal = (at(b) - origin).cross(at(c) - origin);
            sums[a as usize] += *normal;
            sums[b as usize] += *normal;
            sums[c as usize] += *normal;
        }
        for (t, &normal) in surface.topology.faces.iter().zip(normals.iter()) {
            let limit = ALIGNED * ALIGNED * normal.length_squared();
            for &v in t {
                let sum = sums[v as usize];
                let along = normal.dot(sum);
                if !(along > 0.0 && along * along > limit * sum.length_squared()) {
                    flat[v as usize] = Some(false);
                }
            }
        }
    }
}

/// Whether all normals around a particle lie within 60° of their sum.
fn is_flat(v: u32, surface: &Surface, at: impl Fn(u32) -> Vec3A) -> bool {
    let topology = &surface.topology;
    // Each face twice: it has two edges there.
    let faces = || topology.around(v).iter().flat_map(|&(_, e)| topology.edge_faces[e as usize]).filter(|&f| f != NONE);
    let normal = |f: u32| {
        let [a, b, c] = topology.faces[f as usize].map(&at);
        (b - a).cross(c - a)
    };
    let sum: Vec3A = faces().map(normal).sum();
    faces().map(normal).all(|normal| {
        let along = normal.dot(sum);
        along > 0.0 && along * along > ALIGNED * ALIGNED * normal.length_squared() * sum.length_squared()
    })
}
