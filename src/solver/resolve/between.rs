//! The contours between each two cloths, sorted, so that those of a pair are found without a search through all.

use super::contour::ContourGraph;
use super::separation::Member;
use super::view::View;

/// The cloths on the two sides of a contour.
pub(super) fn cloths(view: View<'_>, graph: &ContourGraph, contour: usize) -> Option<[u16; 2]> {
    let &i = graph.nodes_of(contour).first()?;
    let c = &view.crossings[i as usize];
    let (a, b) = (view.surface.part_of_edge(c.edge), view.surface.part_of_face(c.face));
    Some(if graph.side[i as usize] == 0 { [a, b] } else { [b, a] })
}

/// A contour between two different cloths.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Entry {
    /// The smaller number first.
    cloths: [u16; 2],
    contour: u32,
    /// The cloth of its side 0.
    first: u16,
    /// In the first entry of a pair: whether no way undoes all its contours at once.
    failed: bool,
}

/// All contours between different cloths, sorted by pair of cloths. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Between {
    list: Vec<Entry>,
}

impl Between {
    /// Takes in what was analysed last.
    pub(super) fn take_in(&mut self, view: View<'_>, graph: &ContourGraph) {
        self.list.clear();
        if view.surface.parts.len() > 1 {
            let entry = |contour: usize| {
                let [a, b] = cloths(view, graph, contour).filter(|[a, b]| a != b)?;
                Some(Entry { cloths: [a.min(b), a.max(b)], contour: contour as u32, first: a, failed: false })
            };
            self.list.extend((0..graph.contours.len()).filter_map(entry));
            self.list.sort_unstable_by_key(|e| (e.cloths, e.contour));
        }
    }

    /// The contours between two cloths, ascending, the first of which is to be side 0.
    pub(super) fn of(&self, [a, b]: [u16; 2]) -> impl Iterator<Item = Member> + '_ {
        let run = self.list[self.start([a, b])..].iter().take_while(move |e| e.cloths == [a.min(b), a.max(b)]);
        run.map(move |e| Member { contour: e.contour as usize, flip: u8::from(e.first != a) })
    }

    /// Whether some way may still undo all contours between two cloths at once.
    pub(super) fn may_work(&self, pair: [u16; 2]) -> bool {
        self.list.get(self.start(pair)).is_some_and(|e| !e.failed)
    }

    /// Notes that no way undoes all contours between two cloths at once.
    pub(super) fn note_failure(&mut self, pair: [u16; 2]) {
        let start = self.start(pair);
        self.list.get_mut(start).into_iter().for_each(|e| e.failed = true);
    }

    fn start(&self, [a, b]: [u16; 2]) -> usize {
        self.list.partition_point(|e| e.cloths < [a.min(b), a.max(b)])
    }
}
