//! Groups constraints into batches of four that share no particle, so that four are solved at once.
//!
//! Constraints are taken in blocks of [`BLOCK`] in mesh order, coloured within the block, and emitted colour by colour. So
//! particles of a block stay in the first-level cache, and a batch rarely waits for the one before it. Lanes left over repeat a
//! constraint of the same batch, which computes and writes the same values again.

/// Constraints solved at once.
pub const LANES: usize = 4;

/// Constraints coloured together.
pub(super) const BLOCK: usize = 1024;

const COLOURS: u32 = 64;

/// Batches over `elements`, each a list of `N` particles below `particles`. Entries index `elements`.
#[must_use]
pub(super) fn batches<const N: usize>(particles: usize, elements: &[[u32; N]]) -> Vec<[u32; LANES]> {
    let mut used = vec![0u64; particles];
    let mut colour_of: Vec<u32> = Vec::with_capacity(BLOCK);
    let mut out = Vec::with_capacity(elements.len() / LANES + 16);
    for (block, chunk) in elements.chunks(BLOCK).enumerate() {
        let base = (block * BLOCK) as u32;
        colour_of.clear();
        for element in chunk {
            let taken = element.iter().fold(0, |acc, &p| acc | used[p as usize]);
            let colour = (!taken).trailing_zeros();
            if colour < COLOURS {
                for &p in element {
                    used[p as usize] |= 1 << colour;
                }
            }
            colour_of.push(colour);
        }
        let colours = colour_of.iter().copied().filter(|&c| c < COLOURS).max().map_or(0, |c| c + 1);
        for colour in 0..colours {
            let mut lane = 0;
            for (k, _) in colour_of.iter().enumerate().filter(|&(_, &c)| c == colour) {
                let element = base + k as u32;
                if lane == 0 {
                    out.push([element; LANES]);
                } else if let Some(batch) = out.last_mut() {
                    batch[lane] = element;
                }
                lane = (lane + 1) % LANES;
            }
        }
        // A particle with more than 64 constraints in one block: the rest one at a time.
        out.extend(colour_of.iter().enumerate().filter(|&(_, &c)| c >= COLOURS).map(|(k, _)| [base + k as u32; LANES]));
        for element in chunk {
            for &p in element {
                used[p as usize] = 0;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_of_a_batch_share_no_particle_and_every_constraint_is_solved_once() {
        let elements: Vec<[u32; 2]> = (0..3000).map(|i| [i, i + 1]).chain((1..200).map(|i| [0, i * 7])).collect();
        let mut seen = vec![0; elements.len()];
        for batch in batches(4000, &elements) {
            let mut lanes = batch.to_vec();
            lanes.sort_unstable();
            lanes.dedup();
            let mut particles: Vec<u32> = lanes.iter().flat_map(|&e| elements[e as usize]).collect();
            let count = particles.len();
            particles.sort_unstable();
            particles.dedup();
            assert_eq!(particles.len(), count, "batch {batch:?} shares a particle");
            lanes.iter().for_each(|&e| seen[e as usize] += 1);
        }
        assert!(seen.iter().all(|&n| n == 1), "each constraint once");
    }
}
