//! Starts workers, watches them, and keeps what ends them.

use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::options::Options;
use crate::targets::Seeds;
use crate::worker;

/// A worker's address space in KiB. Limits of the cases themselves are far below.
const ADDRESS_SPACE_KIB: u64 = 3 << 20;

/// How the finding of a slow case begins.
pub(crate) const SLOW: &str = "it took more than";

/// A case's number, and whether the one before was accepted.
type Message = (u64, bool);

/// Result of one worker.
struct Ended {
    /// The case that it was at.
    last: Option<u64>,
    cases: u64,
    accepted: u64,
    /// Why it ended, unless the time was up.
    finding: Option<String>,
}

/// Runs workers until the time is up; whether nothing was found.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    let name = options.target.name();
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    let seeds = Seeds::new(options)?;
    let start = Instant::now();
    let deadline = start + Duration::from_secs(options.seconds);
    let (mut cases, mut accepted, mut findings) = (0, 0, 0);
    let mut first = options.only.unwrap_or(0);
    while Instant::now() < deadline {
        let ended = watch(options, first, deadline)?;
        cases += ended.cases;
        accepted += ended.accepted;
        let Some(finding) = ended.finding else { break };
        let number = ended.last.ok_or_else(|| format!("a worker ended before its first case: {finding}"))?;
        first = number + 1;
        if finding.contains(SLOW) && options.only.is_none() && !is_slow_again(options, number)? {
            println!("case {number} was slow once, as on a busy machine, and not again");
            continue;
        }
        findings += 1;
        let file = options.out.join(format!("{name}-{}-{number}.{}", options.seed, options.target.ending()));
        let input = worker::case(&seeds, options.seed, number);
        std::fs::write(&file, input.bytes()).map_err(|error| format!("{}: {error}", file.display()))?;
        println!(
            "finding: --target {name} --seed {} --case {number}, kept as {}: {finding}",
            options.seed,
            file.display()
        );
        if options.only.is_some() {
            break;
        }
    }
    let seconds = start.elapsed().as_secs();
    println!(
        "fuzz {name}: seed {}, {cases} cases, {accepted} accepted, {seconds} s, {findings} findings",
        options.seed
    );
    Ok(findings == 0)
}

/// Runs the case by itself, with four times the time.
fn is_slow_again(options: &Options, number: u64) -> Result<bool, String> {
    let again = Options { only: Some(number), slow: 4 * options.slow, ..options.clone() };
    let ended = watch(&again, number, Instant::now() + Duration::from_secs(20 * options.slow))?;
    Ok(ended.finding.is_some())
}

fn watch(options: &Options, first: u64, deadline: Instant) -> Result<Ended, String> {
    let mut child = spawn(options, first)?;
    let messages = messages(&mut child);
    let complaints = complaints(&mut child);
    let mut ended = Ended { last: None, cases: 0, accepted: 0, finding: None };
    let slow = Duration::from_secs(options.slow);
    // Seeds are made before the first case, and the arguments' cases have a watch of their own.
    let mut wait = slow + Duration::from_secs(30);
    let is_hanging = loop {
        let left = deadline.saturating_duration_since(Instant::now());
        match messages.recv_timeout(wait.min(left)) {
            Ok((number, was_accepted)) => {
                ended.last = Some(number);
                ended.cases += 1;
                ended.accepted += u64::from(was_accepted);
                wait = if options.target.watches_itself() { 3 * slow } else { slow };
            }
            Err(RecvTimeoutError::Timeout) if Instant::now() >= deadline => {
                end(&mut child);
                return Ok(ended);
            }
            Err(RecvTimeoutError::Timeout) => break true,
            Err(RecvTimeoutError::Disconnected) => break false,
        }
    };
    if is_hanging {
        end(&mut child);
        ended.finding = Some(format!("{SLOW} {} s", options.slow));
        return Ok(ended);
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    let said = complaints.recv().unwrap_or_default();
    if !status.success() {
        ended.finding = Some(format!("{status}: {}", said.trim()));
    }
    Ok(ended)
}

/// A worker, with a bounded address space where a shell can bound it.
fn spawn(options: &Options, first: u64) -> Result<Child, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("ulimit -v {ADDRESS_SPACE_KIB} && ulimit -c 0 && exec \"$0\" \"$@\"")]).arg(program);
        shell
    } else {
        Command::new(program)
    };
    command.args(["--target", options.target.name(), "--worker", &first.to_string()]);
    command.args(["--seed", &options.seed.to_string(), "--slow", &options.slow.to_string()]);
    command.arg("--out").arg(&options.out);
    if let Some(only) = options.only {
        command.args(["--case", &only.to_string()]);
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|error| format!("cannot start a worker: {error}"))
}

fn messages(child: &mut Child) -> Receiver<Message> {
    let (sender, receiver) = channel();
    if let Some(mut from) = child.stdout.take() {
        std::thread::spawn(move || {
            let mut message = [0; 9];
            while from.read_exact(&mut message).is_ok() {
                let number = u64::from_le_bytes(std::array::from_fn(|at| message[at]));
                if sender.send((number, message[8] == 1)).is_err() {
                    break;
                }
            }
        });
    }
    receiver
}

/// The first of what the worker says.
fn complaints(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(from) = child.stderr.take() {
        std::thread::spawn(move || {
            let mut said = Vec::new();
            // Sending fails only if the receiver is gone; nobody needs the message then.
            let _ = from.take(4000).read_to_end(&mut said);
            let _ = sender.send(String::from_utf8_lossy(&said).into_owned());
        });
    }
    receiver
}

fn end(child: &mut Child) {
    // With what it started: a command that goes on would write into the files of the cases that follow.
    #[cfg(unix)]
    let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).stderr(Stdio::null()).status();
    // It may have ended by itself meanwhile.
    let _ = child.kill();
    let _ = child.wait();
}
