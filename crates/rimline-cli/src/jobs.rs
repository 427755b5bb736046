//! Many jobs of one subcommand in one run: several files, or a file with a job a line. A job is a command line of its own.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::builder::Resettable;
use clap::parser::ValueSource;
use clap::{Arg, CommandFactory, FromArgMatches as _};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::{Value, json};

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::files::{self, Folders, Inputs, check_parent, is_standard, is_written, real_path};
use crate::input_args::JobsArgs;
use crate::output::{self, collected, complain, print, say};
use crate::{device, lines, shadow};

/// Subcommands that take many jobs, and whether each FILE is a job there. The others take all FILEs as one scene, unless a
/// pattern names results.
const COMMANDS: [(&str, bool); 5] =
    [("draw", true), ("extract", true), ("info", true), ("lines", false), ("shadow", false)];

const FILE: &str = "file";

/// Options of the run, which no job has.
const OF_RUN: [&str; 7] = ["help", "version", "quiet", "json", "jobs", "resume", "shard"];

/// Options that name results, in which patterns stand for parts of the input's name.
const RESULTS: [&str; 3] = ["out", "mask", "save-depth"];
const PATTERNS: [&str; 3] = ["{index}", "{name}", "{stem}"];

/// Options that name inputs, beside the models.
const INPUTS: [&str; 3] = ["displace", "style", "depth"];

const STATUSES: [&str; 4] = ["done", "skipped", "failed", "not_run"];
const DONE: usize = 0;
const SKIPPED: usize = 1;
const FAILED: usize = 2;
const NOT_RUN: usize = 3;

/// Values of options by their long names, and of `file`. `None` is an option without a value.
type Options = BTreeMap<String, Vec<Option<OsString>>>;

/// Many jobs, as the command line asks for them.
pub(crate) struct Many {
    command: clap::Command,
    common: Options,
    args: JobsArgs,
    /// Each FILE is a job.
    is_each: bool,
    is_json: bool,
    pub(crate) is_quiet: bool,
}

struct Job {
    index: usize,
    /// The line of the file of jobs.
    line: Option<usize>,
    files: Vec<PathBuf>,
    /// Inputs beside the models.
    read: Vec<PathBuf>,
    command: Command,
    /// All that it may write. How many lights `file:all` has is not known yet.
    results: Vec<PathBuf>,
}

impl Job {
    /// Whether its results are all there.
    fn is_done(&self) -> bool {
        match &self.command {
            Command::Shadow(args) => shadow::are_written(args),
            _ => !self.results.is_empty() && self.results.iter().all(|file| is_written(file)),
        }
    }
}

impl Many {
    /// Many jobs, if the command line asks for them. A line with an error asks for none, and its own parser tells the error.
    pub(crate) fn given(arguments: &[OsString]) -> Option<Self> {
        const UNSET: Resettable<clap::Id> = Resettable::Reset;
        // `-q` may come first. The definitions below take a while.
        let named = arguments.iter().skip(1).find(|argument| !argument.as_encoded_bytes().starts_with(b"-"))?;
        if !COMMANDS.iter().any(|(command, _)| named == command) {
            return None;
        }
        let optional = |arg: Arg| arg.required(false).required_unless_present(UNSET).requires(UNSET);
        let mut cli = COMMANDS
            .iter()
            .fold(Cli::command(), |cli, (name, _)| cli.mut_subcommand(name, |command| command.mut_args(optional)));
        let matches = cli.try_get_matches_from_mut(arguments).ok()?;
        let (name, matches) = matches.subcommand()?;
        let (_, is_each) = *COMMANDS.iter().find(|(command, _)| *command == name)?;
        let command = cli.find_subcommand(name)?.clone();
        let is_given = |option: &&Arg| {
            !["help", "version"].contains(&option.get_id().as_str())
                && matches.value_source(option.get_id().as_str()) == Some(ValueSource::CommandLine)
        };
        let values = |option: &Arg| match matches.get_raw(option.get_id().as_str()) {
            Some(values) if option.get_action().takes_values() => values.map(|value| Some(value.to_owned())).collect(),
            _ => vec![None],
        };
        let key = |option: &Arg| option.get_long().unwrap_or(FILE).to_owned();
        let mut common: Options =
            command.get_arguments().filter(is_given).map(|option| (key(option), values(option))).collect();
        let args = JobsArgs::from_arg_matches(matches).ok()?;
        let [is_json, is_quiet] = ["json", "quiet"].map(|option| common.contains_key(option));
        common.retain(|option, _| option == "json" || !OF_RUN.contains(&&**option));

        let has_pattern = results(&common).any(|(_, name)| words(&name).next().is_some());
        let is_each = is_each || has_pattern;
        let several = is_each && common.get(FILE).is_some_and(|files| files.len() > 1);
        let is_asked = args.jobs.is_some() || args.resume || args.shard.is_some() || (name == "lines" && is_json);
        (is_asked || several || has_pattern).then_some(Self { command, common, args, is_each, is_json, is_quiet })
    }

    /// Runs the jobs one after the other. One that fails does not stop the others.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        device::keep_open(true);
        let done = self.run_all();
        device::keep_open(false);
        done
    }

    fn run_all(&self) -> Result<(), Failure> {
        let jobs = self.jobs()?;
        self.check_results(&jobs)?;
        output::finish_at_interrupt();
        let begin = Instant::now();
        let in_shard = |job: &&Job| self.args.shard.is_none_or(|[k, n]| job.index % n as usize == k as usize - 1);
        let mut counts = [0; STATUSES.len()];
        for job in jobs.iter().filter(in_shard) {
            counts[if output::is_interrupted() { NOT_RUN } else { self.work(job)? }] += 1;
        }
        let all: usize = counts.iter().sum();
        if self.is_json {
            let mut totals = json!({ "jobs": all, "milliseconds": begin.elapsed().as_secs_f64() * 1e3 });
            STATUSES.into_iter().zip(counts).for_each(|(status, count)| totals[status] = count.into());
            print(&format!("{}\n", json!({ "totals": totals })))?;
        } else {
            let totals = STATUSES.into_iter().zip(counts).map(|(status, count)| format!("{count} {status}"));
            say(&format!("jobs: {}\n", totals.collect::<Vec<_>>().join(", ")))?;
        }
        match (counts[NOT_RUN], counts[FAILED]) {
            (0, 0) => Ok(()),
            (0, failed) => Err(Failure::Jobs { failed, jobs: all }),
            _ => Err(Failure::Interrupted),
        }
    }

    /// Runs a job, or skips it, and reports it. Returns its status.
    fn work(&self, job: &Job) -> Result<usize, Failure> {
        let begin = Instant::now();
        let is_skipped = self.args.resume && job.is_done();
        let run = || if is_skipped { Ok(()) } else { crate::run(&job.command) };
        let (done, printed) = if self.is_json { collected(run) } else { (run(), String::new()) };
        let failure = done.err();
        if let Some(failure) = &failure {
            match failure {
                Failure::Input { .. } if job.line.is_none() => complain(failure),
                _ => complain(&format!("{}: {failure}", self.named(job))),
            }
        }
        let status = if is_skipped {
            SKIPPED
        } else if failure.is_some() {
            FAILED
        } else {
            DONE
        };
        if self.is_json {
            // Not every name is UTF-8, and all JSON is.
            let name = |file: &PathBuf| file.display().to_string();
            let report = json!({
                "job": job.index, "line": job.line, "files": job.files.iter().map(name).collect::<Vec<_>>(),
                "status": STATUSES[status], "code": failure.as_ref().map_or(0, Failure::code),
                "error": failure.map(|failure| failure.to_string()),
                "results": job.results.iter().filter(|file| is_written(file)).map(name).collect::<Vec<_>>(),
                "milliseconds": begin.elapsed().as_secs_f64() * 1e3, "report": serde_json::from_str::<Value>(&printed).ok(),
            });
            print(&format!("{report}\n"))?;
        }
        Ok(status)
    }

    fn named(&self, job: &Job) -> String {
        match (&self.args.jobs, job.line) {
            (Some(file), Some(line)) => format!("{}: line {line}", file.display()),
            _ => job.files.first().map_or_else(String::new, |file| file.display().to_string()),
        }
    }

    fn jobs(&self) -> Result<Vec<Job>, Failure> {
        // Made once, which takes a while.
        let mut cli = Cli::command();
        let Some(file) = &self.args.jobs else {
            let files = self.common.get(FILE).cloned().unwrap_or_default();
            if files.is_empty() || !self.is_each {
                return Ok(vec![self.job(&mut cli, (0, None), self.common.clone())?]);
            }
            let of_file = |(index, file)| {
                let options = self.common.clone().into_iter().chain([(FILE.to_owned(), vec![file])]);
                self.job(&mut cli, (index, None), options.collect())
            };
            return files.into_iter().enumerate().map(of_file).collect();
        };
        let text = files::read_text(file)?;
        let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let of_line = |(index, (line, text)): (usize, (usize, &str))| {
            let given = self.options(text).map_err(|problem| self.wrong(Some(line), &problem))?;
            self.job(&mut cli, (index, Some(line)), self.common.clone().into_iter().chain(given).collect())
        };
        lines.enumerate().map(of_line).collect()
    }

    /// An error in a line of the file of jobs, or in the command line.
    fn wrong(&self, line: Option<usize>, problem: &str) -> Failure {
        let position =
            line.zip(self.args.jobs.as_ref()).map(|(line, file)| format!("{}: line {line}: ", file.display()));
        Failure::usage(format!("{}{problem}", position.unwrap_or_default()))
    }

    fn options(&self, line: &str) -> Result<Options, String> {
        let Entries(entries) = serde_json::from_str(line).map_err(|error| {
            let text = error.to_string();
            let text = text.split_once(" at line ").map_or(&*text, |(text, _)| text);
            format!("column {}: {text}; a line is one JSON object, such as {{\"file\": \"a.obj\"}}", error.column())
        })?;
        let mut options = Options::new();
        for (key, value) in entries {
            let option = self.command.get_arguments().find(|option| option.get_long() == Some(&*key));
            if key != FILE && (option.is_none() || OF_RUN.contains(&&*key)) {
                return Err(format!("`{key}` is no option of a job of `{}`", self.command.get_name()));
            }
            let text = |value: &Value| match value {
                Value::String(text) => Ok(Some(OsString::from(text))),
                Value::Number(number) => Ok(Some(OsString::from(number.to_string()))),
                _ => Err(format!("`{key}` must be a text, a number, true, false, or a list of texts and numbers")),
            };
            let needs_value = option.is_none_or(|option| {
                option.get_action().takes_values() && option.get_num_args().is_none_or(|count| count.min_values() > 0)
            });
            let values = match &value {
                Value::Bool(false) => Vec::new(),
                Value::Bool(true) if needs_value => return Err(format!("`{key}` needs a value")),
                Value::Bool(true) => vec![None],
                Value::Array(list) => list.iter().map(text).collect::<Result<_, _>>()?,
                value => vec![text(value)?],
            };
            if options.insert(key.clone(), values).is_some() {
                return Err(format!("`{key}` is there twice; a list repeats an option"));
            }
        }
        Ok(options)
    }

    fn job(
        &self,
        cli: &mut clap::Command,
        (index, line): (usize, Option<usize>),
        mut options: Options,
    ) -> Result<Job, Failure> {
        let files: Vec<PathBuf> = options.remove(FILE).into_iter().flatten().flatten().map(PathBuf::from).collect();
        if files.len() > 1 && COMMANDS.contains(&(self.command.get_name(), true)) {
            return Err(self.wrong(line, &format!("a job of `{}` has one file", self.command.get_name())));
        }
        let first = files.first().map_or(Path::new(""), PathBuf::as_path);
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let parts = [format!("{index:04}"), part(first.file_name()), part(first.file_stem())];
        let named = |value: OsString| match value.to_str() {
            Some(text) => filled(text, &parts).into(),
            None => value,
        };
        for (option, name) in results(&options) {
            if let Some(word) = words(&name).find(|word| !PATTERNS.contains(word)) {
                let known = PATTERNS.join(", ");
                let problem = format!("--{option} has `{word}`, which stands for nothing; write {known}");
                return Err(self.wrong(line, &problem));
            }
            if option == "out" && name != "-" && !files.is_empty() && filled(&name, &parts) == "-" {
                let problem =
                    format!("--out {name} would be `-`, which is standard output; give another name, or --out -");
                return Err(self.wrong(line, &problem));
            }
        }
        let read = INPUTS.iter().filter_map(|option| options.get(*option)).flatten().flatten();
        let read = read.map(PathBuf::from).collect();
        let mut arguments: Vec<OsString> = vec!["rimline".into(), self.command.get_name().into()];
        for (option, values) in options {
            let is_result = !files.is_empty() && RESULTS.contains(&&*option);
            for value in values {
                let mut argument = OsString::from(format!("--{option}"));
                if let Some(value) = value {
                    argument.push("=");
                    argument.push(if is_result { named(value) } else { value });
                }
                arguments.push(argument);
            }
        }
        arguments.push("--".into());
        arguments.extend(files.iter().map(OsString::from));
        let command = match cli.try_get_matches_from_mut(arguments).and_then(|matches| Cli::from_arg_matches(&matches))
        {
            Ok(cli) => cli.command,
            Err(error) if line.is_none() => crate::refuse(&error),
            Err(error) => return Err(self.wrong(line, &problem(&error))),
        };
        let results = match &command {
            Command::Draw(args) => vec![args.out.clone()],
            Command::Extract(args) => vec![args.out.clone()],
            Command::Lines(args) => lines::files(args).map_err(|error| self.wrong(line, &error.to_string()))?,
            Command::Shadow(args) => shadow::files(args),
            _ => Vec::new(),
        };
        Ok(Job { index, line, files, read, command, results })
    }

    /// Refuses jobs that would write the same file, an input of any of them, or into a folder that is not there.
    fn check_results(&self, jobs: &[Job]) -> Result<(), Failure> {
        let read = Inputs::new(jobs.iter().flat_map(|job| job.files.iter().chain(&job.read)).chain(&self.args.jobs));
        // A job with all lights of a file may have a thousand results, most of which are not there.
        let mut folders = Folders::default();
        let mut writers: HashMap<PathBuf, &Job> = HashMap::new();
        for job in jobs {
            // A film of drawings makes its folder.
            let folder = match &job.command {
                Command::Lines(args) if args.frames.is_some() => Some(&args.out),
                _ => None,
            };
            for file in folder.into_iter().chain(&job.results) {
                let new_path = folders.path_of_new(file);
                if new_path.is_none() {
                    read.spare(file)?;
                }
                if jobs.len() > 1 && is_standard(file) {
                    return Err(Failure::usage(format!(
                        "standard output takes the result of one job, and these are {}; give --out such as \
                         out/{{stem}}.png",
                        jobs.len()
                    )));
                }
                if new_path.is_none() && folder.is_none_or(|folder| folder == file) {
                    check_parent(file).map_err(Failure::output(file))?;
                }
                let path = new_path.or_else(|| real_path(file));
                let Some(other) = path.and_then(|path| writers.insert(path, job)) else { continue };
                if other.index != job.index {
                    let (file, jobs) = (file.clone(), [other, job].map(|job| self.named(job)));
                    return Err(Failure::usage(format!(
                        "{} and {} would both write {}; give other names, or a pattern such as --out out/{{stem}}.png",
                        jobs[0],
                        jobs[1],
                        file.display()
                    )));
                }
            }
        }
        Ok(())
    }
}

/// Options that name results, and the names.
fn results(options: &Options) -> impl Iterator<Item = (&'static str, Cow<'_, str>)> {
    RESULTS.into_iter().flat_map(move |option| {
        let values = options.get(option).into_iter().flatten().flatten();
        values.map(move |value| (option, value.to_string_lossy()))
    })
}

/// A name with the parts instead of [`PATTERNS`]. What looks like a pattern in a part stays.
fn filled(name: &str, parts: &[String; 3]) -> String {
    let (mut text, mut rest) = (String::new(), name);
    let next = |rest: &str| (0..3).filter_map(|of| Some((rest.find(PATTERNS[of])?, of))).min();
    while let Some((at, of)) = next(rest) {
        text.extend([&rest[..at], parts[of].as_str()]);
        rest = &rest[at + PATTERNS[of].len()..];
    }
    text + rest
}

/// Words in braces.
fn words(name: &str) -> impl Iterator<Item = &str> {
    let is_word = |word: &&str| word.len() > 2 && word[1..word.len() - 1].bytes().all(|c| c.is_ascii_lowercase());
    let starts = name.match_indices('{').map(|(at, _)| &name[at..]);
    starts.filter_map(|rest| rest.find('}').map(|end| &rest[..=end])).filter(is_word)
}

/// The parser's message in one line, without the usage.
fn problem(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines: Vec<&str> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let text = lines.join(" ");
    text.strip_prefix("error: ").map_or(text.clone(), str::to_owned)
}

/// The entries of a JSON object, with keys that are there twice.
struct Entries(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for Entries {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Object;
        impl<'de> Visitor<'de> for Object {
            type Value = Entries;

            fn expecting(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                to.write_str("a JSON object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Entries, M::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        from.deserialize_map(Object)
    }
}
