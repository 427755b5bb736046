//! Stencil values against the rays' truth.

use std::collections::BTreeSet;

use glam::DVec2;

use crate::hairlines::Hairlines;
use crate::rays::{Between, Truth};
use rimline_testkit::frames::Frame;
use rimline_testkit::same;

/// Pixels of a frame that are looked at one by one.
const MOST_EXPLAINED: usize = 30;

/// Input of a comparison, for one light.
pub(crate) struct Compared<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) truths: &'a [Vec<Truth>],
    /// The point in each pixel where the stencil counts and the rays go through.
    pub(crate) within_pixel: DVec2,
    pub(crate) light: usize,
    /// Hairlines and slivers are looked for where a pixel is wrong. They know the frame, not `truths`.
    pub(crate) explains: bool,
}

/// Pixels where GPU and truth differ.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wrong {
    pub(crate) pixels: Vec<(u32, u32)>,
    /// Pixels that were compared.
    pub(crate) compared: usize,
    /// Pixels that differ by what hairlines explain, which are not among `pixels`.
    pub(crate) hairlines: BTreeSet<(u32, u32)>,
    /// Pixels that have the count of a part of a pixel around, likewise.
    pub(crate) slivers: BTreeSet<(u32, u32)>,
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
        let pixels = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        pixels.filter(move |(x, y)| (0..size).contains(x) && (0..size).contains(y)).map(|pixel| self.truth(pixel))
    }

    fn value(&self, (x, y): (i64, i64), stencil: &[u8]) -> u8 {
        stencil[(y * i64::from(self.frame.size) + x) as usize]
    }

    /// Pixels of surfaces that are compared and wrong.
    fn wrong(
        &self,
        stencil: &[u8],
        is_compared: impl Fn((i64, i64), Truth) -> bool,
        is_right: impl Fn((i64, i64), Between, u8) -> bool,
    ) -> Wrong {
        let mut wrong = Wrong::default();
        for pixel in self.pixels() {
            let truth = self.truth(pixel);
            let Truth::Surface(between) = truth else { continue };
            if is_compared(pixel, truth) {
                wrong.compared += 1;
                if !is_right(pixel, between, self.value(pixel, stencil)) {
                    wrong.pixels.push((pixel.0 as u32, pixel.1 as u32));
                }
            }
        }
        wrong
    }

    /// Lit surfaces that the GPU shows shadowed, and the other way round, but for those within a pixel of where it
    /// would be right. `every` says of which casters every face casts.
    pub(crate) fn lit(&self, stencil: &[u8], every: &[bool]) -> Wrong {
        let is_near = |pixel, lit: bool| self.around(pixel).any(|near| near.is_lit() == lit);
        let is_right =
            |pixel, between, value: u8| (value == 0) == Truth::Surface(between).is_lit() || is_near(pixel, value == 0);
        self.explained(self.wrong(stencil, |_, _| true, is_right), stencil, every)
    }

    /// Counts that differ from the number of casting faces between, where that is the same for all pixels around.
    pub(crate) fn counts(&self, stencil: &[u8], every: &[bool]) -> Wrong {
        let is_plain = |pixel, truth| self.around(pixel).all(|near| near == truth);
        let is_right = |_, between: Between, value: u8| u16::from(value) == between.count(every) % 256;
        self.explained(self.wrong(stencil, is_plain, is_right), stencil, every)
    }

    /// Counts that differ from those of their pixel's ray: all of them, or only those that swap light and shadow. A
    /// back-facing surface may have any count.
    pub(crate) fn each(&self, stencil: &[u8], every: &[bool], counts: bool) -> Wrong {
        let is_same = |between: Between, value: u8| {
            let count = between.count(every) as u8;
            if counts { count == value } else { (count == 0) == (value == 0) }
        };
        let wrong = self.wrong(stencil, |_, _| true, |_, between, value| is_same(between, value));
        self.explained_by(wrong, stencil, every, |hairlines, pixel, value| {
            hairlines.is_near(pixel, hairlines.moved(pixel), |truth| match truth {
                Truth::Surface(between) => is_same(between, value),
                truth => truth == Truth::BackFacing,
            })
        })
    }

    /// Fails where two draws of the frame differ but for a few pixels: by what hairlines reach, or on a border of a shadow
    /// that is less than half a pixel from where both draws have it. Volumes that end before the last receiver have other far
    /// vertices than volumes that do not, so depths of their sides round otherwise.
    pub(crate) fn alike(&self, what: &str, found: &[u8], expected: &[u8], every: &[bool]) -> Result<(), String> {
        const MOST: usize = 3;
        let mut found = found.to_vec();
        let differing: Vec<usize> = (0..found.len()).filter(|&at| found[at] != expected[at]).collect();
        if !differing.is_empty() && differing.len() <= MOST {
            let hairlines = Hairlines::new(self.frame, self.light, self.within_pixel);
            for at in differing {
                let pixel = (at as u32 % self.frame.size, at as u32 / self.frame.size);
                let [least, most] = hairlines.reach(pixel, every);
                let off = i64::from(found[at].wrapping_sub(expected[at]) as i8);
                let near = hairlines.counts_near(pixel, every);
                if off.abs() <= most - least || near.contains(&found[at]) && near.contains(&expected[at]) {
                    found[at] = expected[at];
                }
            }
        }
        same(what, &found, expected)
    }

    /// Without the pixels that are within a pixel of where their count is right, though no pixel's ray shows it, and
    /// those whose count is off by what a hairline there can make.
    fn explained(&self, wrong: Wrong, stencil: &[u8], every: &[bool]) -> Wrong {
        self.explained_by(wrong, stencil, every, |hairlines, pixel, value| {
            hairlines.is_near(pixel, 1.0, |truth| match truth {
                Truth::Surface(between) => between.count(every) as u8 == value && truth.is_lit() == (value == 0),
                _ => false,
            })
        })
    }

    /// Without those of a hairline, and those that have the value of a point near by.
    fn explained_by(
        &self,
        mut wrong: Wrong,
        stencil: &[u8],
        every: &[bool],
        is_near: impl Fn(&Hairlines<'_>, (u32, u32), u8) -> bool,
    ) -> Wrong {
        // Many have another cause.
        if !self.explains || wrong.pixels.is_empty() || wrong.pixels.len() > MOST_EXPLAINED {
            return wrong;
        }
        let hairlines = Hairlines::new(self.frame, self.light, self.within_pixel);
        wrong.pixels.retain(|&(x, y)| {
            let pixel = (i64::from(x), i64::from(y));
            let Truth::Surface(between) = self.truth(pixel) else { return true };
            let value = self.value(pixel, stencil);
            let off = value.wrapping_sub(between.count(every) as u8) as i8;
            let [least, most] = hairlines.reach((x, y), every);
            // A pixel that is wrong by the choice of faces is none.
            let is_hairline = off != 0 && (least..=most).contains(&i64::from(off));
            let is_sliver = !is_hairline && is_near(&hairlines, (x, y), value);
            let explained = if is_hairline { &mut wrong.hairlines } else { &mut wrong.slivers };
            explained.extend((is_hairline || is_sliver).then_some((x, y)));
            !(is_hairline || is_sliver)
        });
        wrong
    }
}

impl Wrong {
    pub(crate) fn add(&mut self, other: &Self) {
        self.pixels.extend(&other.pixels);
        self.compared += other.compared;
        self.hairlines.extend(&other.hairlines);
        self.slivers.extend(&other.slivers);
    }
}
