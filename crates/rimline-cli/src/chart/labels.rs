//! Places for labels, so that none covers another or a mark.

use super::svg::text_width;

/// Left, top, right and bottom.
pub(super) type Extent = [i32; 4];

/// Occupied areas of a plot.
#[derive(Debug, Default)]
pub(super) struct Room {
    /// Marks and labels; nothing may lie on them.
    taken: Vec<Extent>,
    /// Parts of lines; a label lies on them only where there is no other place.
    lines: Vec<Extent>,
}

/// Half of a line of small text.
const HALF: i32 = 14;

impl Room {
    pub(super) fn take(&mut self, extent: Extent) {
        self.taken.push(extent);
    }

    pub(super) fn take_mark(&mut self, (x, y): (i32, i32), size: i32) {
        self.take([x - size, y - size, x + size, y + size]);
    }

    pub(super) fn take_line(&mut self, points: &[(i32, i32)]) {
        for pair in points.windows(2) {
            let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
            let steps = ((x1 - x0).abs().max((y1 - y0).abs()) / 10).max(1);
            for step in 0..=steps {
                let between = |a: i32, b: i32| a + (b - a) * step / steps;
                let (x, y) = (between(x0, x1), between(y0, y1));
                self.lines.push([x - 2, y - 2, x + 2, y + 2]);
            }
        }
    }

    /// The first of `starts`, each the left end of the text's middle line, from which a text covers nothing and stays
    /// within `frame`; it is taken then.
    pub(super) fn find(
        &mut self,
        text: &str,
        size: f64,
        frame: Extent,
        starts: impl IntoIterator<Item = (i32, i32)>,
    ) -> Option<(i32, i32)> {
        let width = text_width(text, size);
        let extent = |&(x, y): &(i32, i32)| [x - 4, y - HALF, x + width + 4, y + HALF];
        let free: Vec<(i32, i32)> = starts
            .into_iter()
            .filter(|start| {
                let extent = extent(start);
                contains(&frame, &extent) && !self.taken.iter().any(|other| overlap(&extent, other))
            })
            .collect();
        let off_lines = |start: &&(i32, i32)| !self.lines.iter().any(|line| overlap(&extent(start), line));
        let found = free.iter().find(off_lines).or_else(|| free.first()).copied();
        self.taken.extend(found.as_ref().map(extent));
        found
    }
}

fn contains(frame: &Extent, extent: &Extent) -> bool {
    extent[0] >= frame[0] && extent[1] >= frame[1] && extent[2] <= frame[2] && extent[3] <= frame[3]
}

fn overlap(a: &Extent, b: &Extent) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Numbers in ascending order, moved so that neighbours are `step` apart and none is above `most`, if they fit.
pub(super) fn spread(places: &mut [i32], step: i32, most: i32) {
    for at in 1..places.len() {
        places[at] = places[at].max(places[at - 1] + step);
    }
    let mut limit = most;
    for place in places.iter_mut().rev() {
        *place = (*place).min(limit);
        limit = *place - step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Extent = [0, 0, 400, 100];

    #[test]
    fn a_label_covers_nothing() {
        let mut room = Room::default();
        room.take_mark((50, 50), 10);
        let starts = [(40, 50), (70, 50), (70, 80)];
        assert_eq!(room.find("label", 24.0, FRAME, starts), Some((70, 50)), "the first is on the mark");
        assert_eq!(room.find("label", 24.0, FRAME, starts), Some((70, 80)), "the second is taken");
        assert_eq!(room.find("label", 24.0, FRAME, starts), None);
        assert_eq!(room.find("label", 24.0, FRAME, [(390, 20), (200, 5)]), None, "outside");
    }

    #[test]
    fn a_label_keeps_off_lines_where_it_can() {
        let mut room = Room::default();
        room.take_line(&[(0, 50), (400, 50)]);
        assert_eq!(room.find("label", 24.0, FRAME, [(70, 50), (70, 80)]), Some((70, 80)));
        assert_eq!(room.find("label", 24.0, FRAME, [(70, 50), (70, 80)]), Some((70, 50)));
    }

    #[test]
    fn names_are_spread() {
        let mut places = [10, 12, 40, 95];
        spread(&mut places, 20, 100);
        assert_eq!(places, [10, 30, 50, 95]);
        let mut places = [90, 95, 99];
        spread(&mut places, 20, 100);
        assert_eq!(places, [60, 80, 100]);
    }
}
