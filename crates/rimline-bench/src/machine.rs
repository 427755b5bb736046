//! Where and when: the machine, the adapter, the date.

use std::time::{SystemTime, UNIX_EPOCH};

use rimline::cpu::Threads;

#[derive(Clone, Debug)]
pub(crate) struct Machine {
    pub(crate) os: String,
    pub(crate) cpu: String,
    pub(crate) threads: usize,
    /// `false` for a build without optimisation, whose times mean little.
    pub(crate) is_optimised: bool,
    /// UTC, as ISO 8601 has it.
    pub(crate) date: String,
}

#[derive(Clone, Debug)]
pub struct Adapter {
    pub name: String,
    pub backend: String,
    /// For example `discrete GPU`.
    pub kind: String,
    pub driver: String,
    pub has_timestamps: bool,
    /// Speed of a copy, bytes read and written both counted.
    pub copy_gb_per_s: f64,
}

impl Machine {
    pub(crate) fn this() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Self {
            os: os(),
            cpu: cpu().unwrap_or_else(|| "unknown".to_owned()),
            threads: Threads::all().count(),
            is_optimised: !cfg!(debug_assertions),
            date: date(now),
        }
    }
}

impl Adapter {
    pub(crate) fn line(&self) -> String {
        let Self { name, backend, driver, .. } = self;
        if driver.is_empty() { format!("{name} ({backend})") } else { format!("{name} ({backend}, {driver})") }
    }
}

fn os() -> String {
    let release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    let name = release.lines().find_map(|line| line.strip_prefix("PRETTY_NAME=")).map(|name| name.trim_matches('"'));
    let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
    name.map_or_else(|| format!("{os}, {arch}"), |name| format!("{name}, {arch}"))
}

fn cpu() -> Option<String> {
    if let Ok(info) = std::fs::read_to_string("/proc/cpuinfo") {
        let value = |key: &str| {
            let line = info.lines().find(|line| line.starts_with(key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        return value("model name").or_else(|| value("CPU part"));
    }
    let asked = std::process::Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"]).output();
    let output = asked.ok().filter(|output| output.status.success());
    let output = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    output.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
}

/// Seconds since 1970 as `2026-01-31T12:00:00Z`.
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // Years from 1 March of year 0 on, 400 of which have 146,097 days; so the day that leap years add is their last.
    let days = days + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = era * 400 + year + next;
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(super::date(seconds), expected);
        }
    }
}
