//! Numbers particles so that neighbours in the mesh are neighbours in memory (Cuthill and McKee 1969).
//!
//! Randomly numbered particles cost 1.8 times as much at 65,000. Ordering from the pins outwards instead was tried: the same
//! stretch.

use crate::solver::topology::Topology;

/// New number of each particle: breadth-first from a far end of every component, fewer neighbours first.
#[must_use]
pub(super) fn cuthill_mckee(topology: &Topology) -> Vec<u32> {
    let n = topology.particles as usize;
    let mut number = vec![u32::MAX; n];
    let mut queue: Vec<u32> = Vec::with_capacity(n);
    let mut distance = vec![0u32; n];
    let mut ring = Vec::new();
    for seed in 0..n as u32 {
        if number[seed as usize] != u32::MAX {
            continue;
        }
        let start = far_end(topology, seed, &mut distance);
        let first = queue.len();
        number[start as usize] = queue.len() as u32;
        queue.push(start);
        let mut head = first;
        while head < queue.len() {
            let p = queue[head];
            head += 1;
            ring.clear();
            ring.extend(topology.around(p).iter().map(|&(q, _)| q).filter(|&q| number[q as usize] == u32::MAX));
            ring.sort_by_key(|&q| (topology.around(q).len(), q));
            for &q in &ring {
                number[q as usize] = queue.len() as u32;
                queue.push(q);
            }
        }
    }
    number
}

/// The particle of `seed`'s component that is the most edges away from it; the smallest of several.
fn far_end(topology: &Topology, seed: u32, distance: &mut [u32]) -> u32 {
    let mut queue = vec![seed];
    distance[seed as usize] = 1;
    let mut head = 0;
    while head < queue.len() {
        let p = queue[head];
        head += 1;
        for &(q, _) in topology.around(p) {
            if distance[q as usize] == 0 {
                distance[q as usize] = distance[p as usize] + 1;
                queue.push(q);
            }
        }
    }
    let far = queue.iter().map(|&p| distance[p as usize]).max().unwrap_or(0);
    queue.into_iter().filter(|&p| distance[p as usize] == far).min().unwrap_or(seed)
}
