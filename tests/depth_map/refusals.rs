//! What is refused, and how the errors tell.
use rimline_measure::harness::Test;
pub(crate) const TESTS: &[Test] = &[];
