//! The counting methods that are compared.

use rimline::Counting;

use crate::chart::Key;

/// A way to count shadow volumes.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ShadowMethod {
    /// Name in the data.
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    pub(crate) counting: Counting,
    colour: usize,
    shape: usize,
}

pub(crate) const Z_PASS: &str = "z-pass";
pub(crate) const Z_FAIL: &str = "z-fail";
pub(crate) const AUTO: &str = "auto";

pub(crate) const METHODS: [ShadowMethod; 5] = [
    method(Z_PASS, "z-pass", Counting::ZPass, 6, 2),
    method(Z_FAIL, "z-fail", Counting::ZFail, 0, 1),
    method("zp+paper", "ZP+ as published", Counting::ZpPlus2005, 1, 4),
    method("zp+", "ZP+ clipped", Counting::ZpPlus, 2, 3),
    method(AUTO, "auto", Counting::Auto, 4, 0),
];

const fn method(id: &'static str, name: &'static str, counting: Counting, colour: usize, shape: usize) -> ShadowMethod {
    ShadowMethod { id, name, counting, colour, shape }
}

impl ShadowMethod {
    /// Its mark in the plots.
    pub(crate) fn key(&self) -> Key {
        Key { name: self.name.to_owned(), colour: self.colour, shape: self.shape, hollow: false }
    }
}
