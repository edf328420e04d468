//! Stack depth: how many layers of cloth lie between a particle and a body.

/// Steps for each layer `[substeps]`. After as many substeps (22 ms at the default rate), a particle that has left a body lies
/// on nothing. A longer time carries bouncing cloth in the air. A shorter one hides deep piles from their ground, since each
/// pass brings support up by one layer.
const LAYER: u8 = 8;

/// [`LAYER`] times the layers of cloth between a particle and a body, plus the substeps since the lowest of them touched the
/// body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Depth(u8);

impl Depth {
    /// On a body.
    const GROUND: Self = Self(0);
    /// On nothing, or on some thirty layers.
    const FREE: Self = Self(u8::MAX);

    /// Layers between it and a body.
    pub(super) fn layers(self) -> u8 {
        self.0 / LAYER
    }
}

/// The depth of each particle.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Depths(Vec<Depth>);

impl Depths {
    /// Makes room for `particles`.
    pub(super) fn fit(&mut self, particles: usize) {
        self.0.resize(particles, Depth::FREE);
    }

    /// Lets go of particles that have not lain on anything for a while; once a substep.
    pub(super) fn age(&mut self) {
        for Depth(depth) in &mut self.0 {
            *depth = if *depth % LAYER == LAYER - 1 { Depth::FREE.0 } else { *depth + 1 };
        }
    }

    /// Says that a particle lies on a body.
    pub(super) fn ground(&mut self, particle: u32) {
        if let Some(depth) = self.0.get_mut(particle as usize) {
            *depth = Depth::GROUND;
        }
    }

    /// The least of some particles.
    #[inline]
    pub(super) fn least(&self, particles: &[u32]) -> Depth {
        particles.iter().map(|&v| self.0[v as usize]).min().unwrap_or(Depth::FREE)
    }

    /// Says that particles lie on something of that depth, which is not free.
    #[inline]
    pub(super) fn lay(&mut self, particles: &[u32], Depth(on): Depth) {
        for &v in particles {
            let depth = &mut self.0[v as usize];
            *depth = Depth(on + LAYER).min(*depth);
        }
    }
}
