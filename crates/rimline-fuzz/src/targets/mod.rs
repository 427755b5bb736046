//! Targets of fuzzing: seeds made by code, mutations of them, and properties that must hold.

mod arguments;
mod gltf;
mod npz;
mod obj;
mod surfaces;
mod wgsl;

use rimline_testkit::random::Random;

use crate::options::Options;
use crate::target::Target;

/// Input of a case.
#[derive(Clone, Debug)]
pub(crate) enum Input {
    Bytes(Vec<u8>),
    Text(String),
    Arguments(Vec<String>),
}

impl Input {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Bytes(bytes) => bytes.clone(),
            Self::Text(text) => text.clone().into_bytes(),
            Self::Arguments(words) => words.join("\n").into_bytes(),
        }
    }
}

/// A target with its seeds.
pub(crate) enum Seeds {
    Gltf(gltf::Seeds),
    Npz(npz::Seeds),
    Obj,
    Ply,
    Stl,
    Wgsl(wgsl::Seeds),
    Arguments(arguments::Seeds),
}

impl Seeds {
    pub(crate) fn new(options: &Options) -> Result<Self, String> {
        Ok(match options.target {
            Target::Gltf => Self::Gltf(gltf::Seeds::new()),
            Target::Npz => Self::Npz(npz::Seeds::new()?),
            Target::Obj => Self::Obj,
            Target::Ply => Self::Ply,
            Target::Stl => Self::Stl,
            Target::Wgsl => Self::Wgsl(wgsl::Seeds::new()),
            Target::Arguments => Self::Arguments(arguments::Seeds::new(options)?),
        })
    }

    pub(crate) fn case(&self, random: &mut Random) -> Input {
        match self {
            Self::Gltf(seeds) => Input::Bytes(seeds.case(random)),
            Self::Npz(seeds) => Input::Bytes(seeds.case(random)),
            Self::Obj => Input::Bytes(obj::case(random)),
            Self::Ply => Input::Bytes(surfaces::ply_case(random)),
            Self::Stl => Input::Bytes(surfaces::stl_case(random)),
            Self::Wgsl(seeds) => Input::Text(seeds.case(random)),
            Self::Arguments(seeds) => Input::Arguments(seeds.case(random)),
        }
    }

    /// Whether the input was accepted; an error if what came of it is wrong.
    pub(crate) fn run(&self, input: &Input) -> Result<bool, String> {
        match (self, input) {
            (Self::Gltf(_), Input::Bytes(bytes)) => gltf::run(bytes),
            (Self::Npz(seeds), Input::Bytes(bytes)) => seeds.run(bytes),
            (Self::Obj, Input::Bytes(bytes)) => obj::run(bytes),
            (Self::Ply, Input::Bytes(bytes)) => surfaces::run_ply(bytes),
            (Self::Stl, Input::Bytes(bytes)) => surfaces::run_stl(bytes),
            (Self::Wgsl(_), Input::Text(text)) => wgsl::run(text),
            (Self::Arguments(seeds), Input::Arguments(words)) => seeds.run(words),
            _ => Err("the input is another target's".to_owned()),
        }
    }
}
