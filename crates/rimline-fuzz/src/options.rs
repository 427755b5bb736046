//! The harness's own arguments.

use std::path::PathBuf;

use crate::target::Target;

pub(crate) const USAGE: &str = "\
Usage: rimline-fuzz --target gltf|npz|obj|ply|stl|wgsl|args [--seconds 60] [--seed N] [--slow 5] [--out target/fuzz] [--case N]

--case N runs the one case of that number.";

#[derive(Clone, Debug)]
pub(crate) struct Options {
    pub(crate) target: Target,
    pub(crate) seconds: u64,
    pub(crate) seed: u64,
    /// A case that takes more seconds is a finding.
    pub(crate) slow: u64,
    pub(crate) out: PathBuf,
    /// The only case to run.
    pub(crate) only: Option<u64>,
    /// In a worker: the first case.
    pub(crate) worker_from: Option<u64>,
}

impl Options {
    pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            target: Target::Gltf,
            seconds: 60,
            seed: 1,
            slow: 5,
            out: "target/fuzz".into(),
            only: None,
            worker_from: None,
        };
        let mut target = None;
        while let Some(word) = words.next() {
            let value = words.next().ok_or_else(|| format!("`{word}` needs a value"))?;
            let number = || value.parse::<u64>().map_err(|_| format!("`{word} {value}` is no number"));
            match word.as_str() {
                "--target" => target = Some(Target::named(&value).ok_or_else(|| format!("no target `{value}`"))?),
                "--seconds" => options.seconds = number()?,
                "--seed" => options.seed = number()?,
                "--slow" => options.slow = number()?,
                "--case" => options.only = Some(number()?),
                "--worker" => options.worker_from = Some(number()?),
                "--out" => options.out = value.into(),
                _ => return Err(format!("unknown option `{word}`")),
            }
        }
        options.target = target.ok_or("give a --target")?;
        Ok(options)
    }
}
