//! Installing packages with the system's package manager.

use std::fs;
use std::process::Command;

use crate::process;

/// A package manager that is known to have Mesa's software driver and the Vulkan loader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manager {
    Apt,
    Dnf,
    Pacman,
}

impl Manager {
    /// The one that this system's `os-release` speaks for.
    pub(crate) fn of_this_system() -> Option<Self> {
        let release =
            ["/etc/os-release", "/usr/lib/os-release"].iter().find_map(|path| fs::read_to_string(path).ok())?;
        Self::of_release(&release)
    }

    fn of_release(release: &str) -> Option<Self> {
        let value = |key: &str| {
            let line = release.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
            line.unwrap_or_default().trim_matches(['"', '\'']).to_lowercase()
        };
        // Its own name first, then those of the distributions that it descends from, nearest first.
        let names = format!("{} {}", value("ID"), value("ID_LIKE"));
        names.split_whitespace().find_map(|name| match name {
            "debian" | "ubuntu" => Some(Self::Apt),
            "fedora" | "rhel" | "centos" => Some(Self::Dnf),
            "arch" | "archlinux" => Some(Self::Pacman),
            _ => None,
        })
    }

    /// Commands that install the driver and the loader, step by step.
    fn steps(self) -> &'static [&'static [&'static str]] {
        match self {
            Self::Apt => &[
                &["apt-get", "update"],
                &["apt-get", "install", "-y", "--no-install-recommends", "mesa-vulkan-drivers", "libvulkan1"],
            ],
            Self::Dnf => &[&["dnf", "install", "-y", "mesa-vulkan-drivers", "vulkan-loader"]],
            Self::Pacman => &[&["pacman", "-Sy", "--needed", "--noconfirm", "vulkan-swrast", "vulkan-icd-loader"]],
        }
    }

    /// Commands that install a browser with `SwiftShader`. Empty where its location is not known.
    fn steps_of_swiftshader(self) -> &'static [&'static [&'static str]] {
        match self {
            Self::Apt => {
                &[&["apt-get", "update"], &["apt-get", "install", "-y", "--no-install-recommends", "chromium"]]
            }
            Self::Dnf | Self::Pacman => &[],
        }
    }

    /// Commands that install a display without a screen, and libraries that windows there load. Empty where tests do
    /// without.
    fn steps_of_xvfb(self) -> &'static [&'static [&'static str]] {
        match self {
            Self::Apt => &[
                &["apt-get", "update"],
                &[
                    "apt-get",
                    "install",
                    "-y",
                    "--no-install-recommends",
                    "xvfb",
                    "libx11-xcb1",
                    "libxcursor1",
                    "libxi6",
                    "libxkbcommon-x11-0",
                    "libxrandr2",
                ],
            ],
            Self::Dnf | Self::Pacman => &[],
        }
    }

    /// All steps as one line for a user's shell.
    pub(crate) fn one_command(self) -> String {
        one_command(self.steps())
    }

    /// Installs the driver and the loader, as root or through a sudo that asks for no password.
    pub(crate) fn install(self) -> Result<(), String> {
        run("Vulkan driver", self.steps())
    }

    /// Installs Xvfb, likewise.
    pub(crate) fn install_xvfb(self) -> Result<(), String> {
        let steps = self.steps_of_xvfb();
        if steps.is_empty() { Ok(()) } else { run("Xvfb", steps) }
    }

    /// Installs `SwiftShader`, likewise.
    pub(crate) fn install_swiftshader(self) -> Result<(), String> {
        let steps = self.steps_of_swiftshader();
        if steps.is_empty() { Ok(()) } else { run("SwiftShader", steps) }
    }
}

fn one_command(steps: &[&[&str]]) -> String {
    let steps = steps.iter().map(|step| format!("sudo {}", step.join(" ")));
    steps.collect::<Vec<_>>().join(" && ")
}

fn run(what: &str, steps: &[&[&str]]) -> Result<(), String> {
    let by_sudo = !is_root();
    if by_sudo && process::output(Command::new("sudo").args(["-n", "true"])).is_err() {
        return Err(format!(
            "no {what} found, and installing one needs rights that this user lacks; please run\n\n    {}\n",
            one_command(steps)
        ));
    }
    let mut said = String::new();
    let mut succeeded = true;
    for step in steps {
        let mut command = Command::new(if by_sudo { "sudo" } else { "env" });
        if by_sudo {
            command.args(["-n", "env"]);
        }
        // Only the last step has to succeed: a list of packages may be stale in a source that matters not.
        let outcome = process::output(command.arg("DEBIAN_FRONTEND=noninteractive").args(*step));
        succeeded = outcome.is_ok();
        said += &outcome.unwrap_or_else(|error| error);
    }
    if succeeded {
        return Ok(());
    }
    Err(format!(
        "no {what} found, and installing one failed. The command was\n\n    {}\n\nand it said:\n{said}",
        one_command(steps)
    ))
}

fn is_root() -> bool {
    process::output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}

#[cfg(test)]
mod tests {
    use super::Manager;

    #[test]
    fn distributions_and_their_descendants_have_a_manager() {
        for (release, manager) in [
            ("NAME=\"Debian\"\nID=debian\n", Some(Manager::Apt)),
            ("ID=linuxmint\nID_LIKE=\"ubuntu debian\"\n", Some(Manager::Apt)),
            ("VERSION_ID=41\nID=fedora\n", Some(Manager::Dnf)),
            ("ID=\"rocky\"\nID_LIKE=\"rhel centos fedora\"\n", Some(Manager::Dnf)),
            ("ID=arch\nBUILD_ID=rolling\n", Some(Manager::Pacman)),
            ("ID=manjaro\nID_LIKE=arch\n", Some(Manager::Pacman)),
            ("ID=nixos\n", None),
            ("", None),
        ] {
            assert_eq!(Manager::of_release(release), manager, "{release}");
        }
    }

    #[test]
    fn the_command_is_one_line_with_every_package() {
        for manager in [Manager::Apt, Manager::Dnf, Manager::Pacman] {
            let command = manager.one_command();
            assert!(command.starts_with("sudo ") && !command.contains('\n'), "{command}");
            assert!(command.contains("vulkan"), "{command}");
        }
    }
}
