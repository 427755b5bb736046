//! Runs case after case, and says which.

use std::io::Write as _;

use rimline_testkit::random::Random;

use crate::options::Options;
use crate::targets::{Input, Seeds};

/// Exit code of a worker after a case with a wrong result. The worker writes the message to standard error.
pub(crate) const WRONG: i32 = 102;
/// Stack size that Rust gives threads by default. A case that needs more overflows.
const STACK_BYTES: usize = 2 << 20;

/// The case of this number.
pub(crate) fn case(seeds: &Seeds, seed: u64, number: u64) -> Input {
    seeds.case(&mut Random::new(seed.wrapping_mul(0x0001_0000_0000_0001).wrapping_add(number)))
}

/// Runs cases from `first` on until it is killed, or the only case if one is asked for. Each case's number goes to standard
/// output before it runs, with 1 if the case before was accepted.
pub(crate) fn run(options: &Options, first: u64) -> Result<bool, String> {
    let options = options.clone();
    let work = move || {
        let seeds = Seeds::new(&options)?;
        let mut to = std::io::stdout().lock();
        let mut accepted = false;
        let last = options.only.map_or(u64::MAX, |only| only + 1);
        for number in first..last {
            let input = case(&seeds, options.seed, number);
            let mut message = number.to_le_bytes().to_vec();
            message.push(u8::from(accepted));
            // The supervisor is gone.
            if to.write_all(&message).and_then(|()| to.flush()).is_err() {
                return Ok(true);
            }
            match seeds.run(&input) {
                Ok(was_accepted) => accepted = was_accepted,
                Err(error) => {
                    eprintln!("{error}");
                    std::process::exit(WRONG);
                }
            }
        }
        Ok(true)
    };
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(work).map_err(|error| error.to_string())?;
    // A panic in the thread has been printed.
    thread.join().unwrap_or_else(|_| std::process::exit(101))
}
