//! Where the cloth hardly bends: faces of one fan are hardly closer there than at rest.

use glam::{Vec3A, Vec4};

use crate::solver::detect::Surface;
use crate::solver::scales::ALIGNED;
use crate::solver::topology::NONE;

/// Asked for more than one in this many particles, it is cheaper to find out about all.
const ONE_IN: usize = 64;

/// Where the cloth hardly bends: particles around which all normals lie, and will lie, within 60° of their sum. Distances
/// across a crease are at least half of those at rest there.
#[derive(Debug, Default)]
pub(super) struct Flatness {
    /// Normals of faces as long as twice their area `[m²]`, and their sums around particles.
    normals: Vec<Vec3A>,
    sums: Vec<Vec3A>,
    /// Whether particles are flat; none where it was not asked for since everything moved.
    flat: Vec<Option<bool>>,
    /// Particles for which it was.
    asked: u32,
    /// Faces around a particle.
    fan: Vec<u32>,
}

impl Flatness {
    /// Everything moved: nothing is known of so many particles.
    pub(super) fn forget(&mut self, particles: usize) {
        self.asked = 0;
        self.flat.clear();
        self.flat.resize(particles, None);
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
            let flat = is_flat(v, surface, &mut self.fan, now) && is_flat(v, surface, &mut self.fan, then);
            self.flat[v as usize] = Some(flat);
            return flat;
        }
        self.find_all(surface, positions, ahead);
        self.is_known(v)
    }

    /// Finds out about all particles.
    pub(super) fn find_all(&mut self, surface: &Surface, positions: &[Vec4], ahead: &[Vec3A]) {
        self.asked = self.flat.len() as u32;
        self.flat.fill(Some(true));
        self.keep(surface, |v| Vec3A::from_vec4(positions[v as usize]));
        self.keep(surface, |v| ahead[v as usize]);
    }

    /// Whether particle `v` is known to be flat.
    #[inline]
    pub(super) fn is_known(&self, v: u32) -> bool {
        self.flat[v as usize] == Some(true)
    }

    fn keep(&mut self, surface: &Surface, at: impl Fn(u32) -> Vec3A) {
        let Self { normals, sums, flat, .. } = self;
        sums.clear();
        sums.resize(flat.len(), Vec3A::ZERO);
        normals.resize(surface.topology.faces.len(), Vec3A::ZERO);
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

/// Whether all normals around a particle lie within 60° of their sum. With the bits of [`Flatness::keep`], which sums in the
/// order of faces.
fn is_flat(v: u32, surface: &Surface, fan: &mut Vec<u32>, at: impl Fn(u32) -> Vec3A) -> bool {
    let topology = &surface.topology;
    fan.clear();
    fan.extend(topology.around(v).iter().flat_map(|&(_, e)| topology.edge_faces[e as usize]).filter(|&f| f != NONE));
    // Each face twice: it has two edges there.
    fan.sort_unstable();
    fan.dedup();
    let normal = |&f: &u32| {
        let [a, b, c] = topology.faces[f as usize].map(&at);
        (b - a).cross(c - a)
    };
    let mut sum = Vec3A::ZERO;
    fan.iter().map(normal).for_each(|normal| sum += normal);
    fan.iter().map(normal).all(|normal| {
        let along = normal.dot(sum);
        along > 0.0 && along * along > ALIGNED * ALIGNED * normal.length_squared() * sum.length_squared()
    })
}
