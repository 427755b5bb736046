//! Stencil values against the rays' truth.

use crate::rays::Truth;
use crate::scene::Frame;

/// What of a frame is compared, for one light.
pub(crate) struct Compared<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) truths: &'a [Vec<Truth>],
    pub(crate) light: usize,
}

/// Pixels where GPU and truth differ.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wrong {
    pub(crate) pixels: Vec<(u32, u32)>,
    /// Pixels that were compared.
    pub(crate) compared: usize,
}

impl Compared<'_> {
    fn truth(&self, (x, y): (i64, i64)) -> Truth {
        self.truths[(y * i64::from(self.frame.size) + x) as usize][self.light]
    }

    fn pixels(&self) -> impl Iterator<Item = (i64, i64)> + use<> {
        let size = i64::from(self.frame.size);
        (0..size).flat_map(move |y| (0..size).map(move |x| (x, y)))
    }

    /// The pixel and those around it.
    fn around(&self, (x, y): (i64, i64)) -> impl Iterator<Item = Truth> {
        let size = i64::from(self.frame.size);
        let places = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        places.filter(move |(x, y)| (0..size).contains(x) && (0..size).contains(y)).map(|place| self.truth(place))
    }

    fn value(&self, (x, y): (i64, i64), stencil: &[u8]) -> u8 {
        stencil[(y * i64::from(self.frame.size) + x) as usize]
    }

    /// Lit surfaces that the GPU shows shadowed, and the other way round, but for those within a pixel of where it
    /// would be right.
    pub(crate) fn lit(&self, stencil: &[u8]) -> Wrong {
        let mut wrong = Wrong::default();
        for place in self.pixels() {
            let truth = self.truth(place);
            if !matches!(truth, Truth::Surface(_)) {
                continue;
            }
            wrong.compared += 1;
            let lit = self.value(place, stencil) == 0;
            if lit != truth.is_lit() && !self.around(place).any(|near| near.is_lit() == lit) {
                wrong.pixels.push((place.0 as u32, place.1 as u32));
            }
        }
        wrong
    }

    /// Counts that differ from the number of casting faces between, where that is the same for all pixels around.
    /// `every` says of which casters every face casts.
    pub(crate) fn counts(&self, stencil: &[u8], every: &[bool]) -> Wrong {
        let mut wrong = Wrong::default();
        for place in self.pixels() {
            let truth = self.truth(place);
            let Truth::Surface(between) = truth else { continue };
            if self.around(place).any(|near| near != truth) {
                continue;
            }
            wrong.compared += 1;
            if u16::from(self.value(place, stencil)) != between.count(every) % 256 {
                wrong.pixels.push((place.0 as u32, place.1 as u32));
            }
        }
        wrong
    }
}

impl Wrong {
    pub(crate) fn add(&mut self, other: &Self) {
        self.pixels.extend(&other.pixels);
        self.compared += other.compared;
    }
}
