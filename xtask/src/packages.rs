//! Installing packages with the system's package manager.

use std::process::Command;

use crate::process;

/// A package manager, and the names of its packages. Where there are none, their location is not known, or tests do without.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Manager {
    /// Distributions that have it, by the IDs of `os-release`.
    systems: &'static [&'static str],
    /// Commands before the packages.
    steps: &'static [&'static str],
    /// Mesa's software driver, and the Vulkan loader.
    pub(crate) vulkan: &'static str,
    /// A browser with `SwiftShader`.
    pub(crate) swiftshader: &'static str,
    /// A display without a screen, and libraries that windows there load.
    pub(crate) xvfb: &'static str,
}

static MANAGERS: [Manager; 3] = [
    Manager {
        systems: &["debian", "ubuntu"],
        steps: &["apt-get update", "apt-get install -y --no-install-recommends"],
        vulkan: "mesa-vulkan-drivers libvulkan1",
        swiftshader: "chromium",
        xvfb: "xvfb libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 libxrandr2",
    },
    Manager {
        systems: &["fedora", "rhel", "centos"],
        steps: &["dnf install -y"],
        vulkan: "mesa-vulkan-drivers vulkan-loader",
        swiftshader: "",
        xvfb: "",
    },
    Manager {
        systems: &["arch", "archlinux"],
        steps: &["pacman -Sy --needed --noconfirm"],
        vulkan: "vulkan-swrast vulkan-icd-loader",
        swiftshader: "",
        xvfb: "",
    },
];

impl Manager {
    /// The one that this system's `os-release` speaks for.
    pub(crate) fn of_this_system() -> Option<&'static Self> {
        let files = ["/etc/os-release", "/usr/lib/os-release"];
        Self::of_release(&files.iter().find_map(|path| std::fs::read_to_string(path).ok())?)
    }

    fn of_release(release: &str) -> Option<&'static Self> {
        let value = |key: &str| {
            let line = release.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
            line.unwrap_or_default().trim_matches(['"', '\'']).to_lowercase()
        };
        // Its own name first, then those of the distributions that it descends from, nearest first.
        let names = format!("{} {}", value("ID"), value("ID_LIKE"));
        names.split_whitespace().find_map(|name| MANAGERS.iter().find(|manager| manager.systems.contains(&name)))
    }

    /// The commands that install packages.
    fn commands(&self, packages: &str) -> Vec<String> {
        let last = self.steps.len() - 1;
        let command =
            |(at, step): (usize, &&str)| if at == last { format!("{step} {packages}") } else { (*step).to_owned() };
        self.steps.iter().enumerate().map(command).collect()
    }

    /// The same as one line for a user's shell.
    pub(crate) fn one_command(&self, packages: &str) -> String {
        self.commands(packages).iter().map(|command| format!("sudo {command}")).collect::<Vec<_>>().join(" && ")
    }

    /// Installs packages, if there are any, as root or through a sudo that asks for no password.
    pub(crate) fn install(&self, what: &str, packages: &str) -> Result<(), String> {
        if packages.is_empty() {
            return Ok(());
        }
        let is_root = process::output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
        let line = self.one_command(packages);
        if !is_root && process::output(Command::new("sudo").args(["-n", "true"])).is_err() {
            return Err(format!(
                "no {what} found, and installing one needs rights that this user lacks; please run\n\n    {line}\n"
            ));
        }
        let (program, arguments): (_, &[&str]) = if is_root { ("env", &[]) } else { ("sudo", &["-n", "env"]) };
        let (mut said, mut succeeded) = (String::new(), true);
        for step in self.commands(packages) {
            let mut command = Command::new(program);
            command.args(arguments);
            // Only the last step has to succeed: a list of packages may be stale in a source that matters not.
            let outcome = process::output(command.arg("DEBIAN_FRONTEND=noninteractive").args(step.split(' ')));
            succeeded = outcome.is_ok();
            said += &outcome.unwrap_or_else(|error| error);
        }
        let failed = format!(
            "no {what} found, and installing one failed. The command was\n\n    {line}\n\nand it said:\n{said}"
        );
        if succeeded { Ok(()) } else { Err(failed) }
    }
}

#[cfg(test)]
mod tests {
    use super::{MANAGERS, Manager};

    #[test]
    fn distributions_and_their_descendants_have_a_manager() {
        for (release, manager) in [
            ("NAME=\"Debian\"\nID=debian\n", Some(0)),
            ("ID=linuxmint\nID_LIKE=\"ubuntu debian\"\n", Some(0)),
            ("VERSION_ID=41\nID=fedora\n", Some(1)),
            ("ID=\"rocky\"\nID_LIKE=\"rhel centos fedora\"\n", Some(1)),
            ("ID=arch\nBUILD_ID=rolling\n", Some(2)),
            ("ID=manjaro\nID_LIKE=arch\n", Some(2)),
            ("ID=nixos\n", None),
            ("", None),
        ] {
            assert_eq!(Manager::of_release(release), manager.map(|manager: usize| &MANAGERS[manager]), "{release}");
        }
    }

    #[test]
    fn the_command_is_one_line_with_every_package() {
        let expected =
            "sudo apt-get update && sudo apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1";
        assert_eq!(MANAGERS[0].one_command(MANAGERS[0].vulkan), expected);
        for manager in &MANAGERS {
            let command = manager.one_command(manager.vulkan);
            assert!(command.starts_with("sudo ") && command.ends_with(manager.vulkan), "{command}");
            assert!(command.contains("vulkan") && !command.contains('\n'), "{command}");
        }
        assert_eq!(MANAGERS[1].install("display", MANAGERS[1].xvfb), Ok(()), "nothing to install");
    }
}
