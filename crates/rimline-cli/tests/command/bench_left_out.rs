//! A build without the feature `bench` says so.

use super::run::rimline;
use super::{Outcome, Test};

pub(crate) const TESTS: &[Test] = &[("bench::a_build_without_it_says_so", left_out)];

fn left_out() -> Outcome {
    for line in ["bench", "bench --quick --report report", "bench --schema"] {
        rimline(line.split(' ')).expect(2, &["leaves `bench` out", "--features bench"])?;
    }
    Ok(())
}
