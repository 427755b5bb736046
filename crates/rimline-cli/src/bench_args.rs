//! Options of `rimline bench`.

#[cfg(feature = "bench")]
mod full;

#[cfg(feature = "bench")]
pub(crate) use full::{BenchArgs, Number};

/// All options are taken, and none is followed: this build does not measure.
#[cfg(not(feature = "bench"))]
#[derive(clap::Args, Debug)]
#[command(disable_help_flag = true)]
pub(crate) struct BenchArgs {
    /// This build leaves the measurements out
    #[arg(hide = true, allow_hyphen_values = true, trailing_var_arg = true)]
    _rest: Vec<std::ffi::OsString>,
}
