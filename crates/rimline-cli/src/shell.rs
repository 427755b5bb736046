//! `rimline completions` and `rimline man`: what a shell and a reader of manual pages want of the definition of the command.

use std::io::{self, Write as _};
use std::path::Path;

use clap::{Command, CommandFactory};

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Failure;
use crate::files::check_folder;
use crate::output::{Filled, Folder, Line, Output, printed, say};

const NAME: &str = "rimline";

pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), NAME, &mut script);
    let mut stdout = io::stdout().lock();
    printed(stdout.write_all(&script).and_then(|()| stdout.flush()))
}

/// Writes a page for the command and one for each subcommand.
pub(crate) fn man(args: &ManArgs) -> Result<(), Failure> {
    let folder = &args.folder;
    check_folder(folder, "the manual is a folder of pages; give the name of a folder")?;
    let _folder = Folder::create(folder)?;
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let mut pages = vec![page(folder, command.clone(), NAME)?];
    for subcommand in command.get_subcommands() {
        let name = format!("{NAME}-{}", subcommand.get_name());
        pages.push(page(folder, subcommand.clone(), &name)?);
    }
    let count = pages.len();
    Filled::finish_all(pages)?;
    say(&format!(
        "wrote {count} pages into {}; `man {}` shows one\n",
        Line(folder.display()),
        Line(folder.join("rimline.1").display())
    ))
}

fn page(folder: &Path, command: Command, name: &str) -> Result<Filled, Failure> {
    let page = clap_mangen::Man::new(command.display_name(name)).title(name.to_uppercase());
    Output::create(&folder.join(format!("{name}.1")))?.fill(|file| page.render(file))
}
