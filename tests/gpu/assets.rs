//! Every good file of the assets at several times: GPU against twin, closure. `common::assets` finds the folder.

pub(crate) const TESTS: &[crate::Test] = &[];
