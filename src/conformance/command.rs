//! Another program as a renderer: a command template, run once a batch.
//!
//! The template is split into words as a POSIX shell would, quotes and backslashes included, *before* anything is filled
//! in; no shell is involved, so paths with spaces or quotes stay one word. `{input}` and `{output}` are absolute paths (the
//! output is an `.exr`), `{width}`, `{height}`, `{spp}` and `{seed}` whole numbers, `{environment}` the uniform radiance as
//! `R,G,B` (`0,0,0` without one), for programs that do not read `EXT_lights_image_based`.

use super::{ConformanceError, Job};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// What is kept of what a program says on standard error, in bytes from its end.
const MOST_SAID: u64 = 4000;
/// How often a running program is looked at.
const POLL: Duration = Duration::from_millis(10);

/// The places of a template and whether one must be there.
const PLACES: [(&str, bool); 7] = [
    ("{input}", true),
    ("{output}", true),
    ("{width}", true),
    ("{height}", true),
    ("{spp}", false),
    ("{seed}", false),
    ("{environment}", false),
];

/// A command line with places to fill in.
#[derive(Clone, Debug, PartialEq)]
pub struct CommandTemplate {
    words: Vec<String>,
    /// A run that takes longer is ended.
    pub timeout: Duration,
}

impl CommandTemplate {
    /// Splits a template into words and checks that input, output and size are in it.
    pub fn new(template: &str, timeout: Duration) -> Result<Self, ConformanceError> {
        let invalid = |text: String| Err(ConformanceError::Template(text));
        let Some(words) = shlex::split(template) else {
            return invalid(format!("{template:?} has a quote that is not closed"));
        };
        if words.is_empty() {
            return invalid("the command is empty".to_owned());
        }
        for (place, _) in PLACES.iter().filter(|(_, required)| *required) {
            if !words.iter().any(|word| word.contains(place)) {
                return invalid(format!("the command lacks {place}"));
            }
        }
        Ok(Self { words, timeout })
    }

    /// Whether runs with different seeds differ.
    pub fn has_seed(&self) -> bool {
        self.words.iter().any(|word| word.contains("{seed}"))
    }

    /// The words with everything filled in. A value that looks like a place stays as it is.
    fn fill(&self, job: &Job<'_>, output: &Path) -> Vec<OsString> {
        let asset = job.case.asset();
        let input = asset.canonicalize().unwrap_or(asset);
        let environment = job.case.environment.unwrap_or_default();
        let values = [
            input.into_os_string(),
            output.as_os_str().to_owned(),
            job.case.width.to_string().into(),
            job.case.height.to_string().into(),
            job.spp.to_string().into(),
            job.seed.to_string().into(),
            environment.map(|v| v.to_string()).join(",").into(),
        ];
        self.words.iter().map(|word| fill_word(word, &values)).collect()
    }

    /// Runs the program until it ends or the time is up. The error says what went wrong, with what the program said.
    pub(super) fn run(
        &self,
        job: &Job<'_>,
        output: &Path,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(), String> {
        let words = self.fill(job, output);
        let mut said = tempfile::tempfile().map_err(|e| format!("no temporary file: {e}"))?;
        let log = |said: &File| said.try_clone().map(Stdio::from).map_err(|e| e.to_string());
        let mut command = Command::new(&words[0]);
        command.args(&words[1..]).stdin(Stdio::null()).stdout(log(&said)?).stderr(log(&said)?);
        let mut running =
            Running::start(&mut command).map_err(|e| format!("cannot start {:?}: {e}", words[0]))?;
        let started = Instant::now();
        let status = loop {
            match running.child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if started.elapsed() > self.timeout || cancelled() => {
                    running.end();
                    let limit = self.timeout.as_secs_f64();
                    let why = if cancelled() {
                        "interrupted".into()
                    } else {
                        format!("not finished after {limit} s")
                    };
                    return Err(format!("{why}{}", quote(&mut said)));
                }
                Ok(None) => std::thread::sleep(POLL),
                Err(error) => return Err(format!("cannot wait for {:?}: {error}", words[0])),
            }
        };
        if !status.success() {
            return Err(format!("{:?} ended with {status}{}", words[0], quote(&mut said)));
        }
        if !output.is_file() {
            return Err(format!("{:?} wrote no picture{}", words[0], quote(&mut said)));
        }
        Ok(())
    }
}

/// Programs that run now, by the process that was started.
static RUNNING: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// Ends every renderer that runs, with all that it has started, for a process that ends itself.
pub fn end_renderers() {
    RUNNING.lock().unwrap_or_else(std::sync::PoisonError::into_inner).iter().for_each(|&id| end_group(id));
}

/// A program with whatever it starts: a script that starts the renderer proper, which would go on without it.
struct Running {
    child: Child,
}

impl Running {
    fn start(command: &mut Command) -> std::io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        // Under the lock, so that none is started after all have been ended.
        let mut running = RUNNING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let child = command.spawn()?;
        running.push(child.id());
        Ok(Self { child })
    }

    fn end(&mut self) {
        end_group(self.child.id());
        // It may have ended by itself just now; then there is nothing to end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let id = self.child.id();
        RUNNING.lock().unwrap_or_else(std::sync::PoisonError::into_inner).retain(|&other| other != id);
    }
}

/// Ends all processes of a group, if there is one.
fn end_group(leader: u32) {
    #[cfg(unix)]
    if let Ok(leader) = i32::try_from(leader) {
        use nix::sys::signal::{Signal, killpg};
        let _ = killpg(nix::unistd::Pid::from_raw(leader), Signal::SIGKILL);
    }
    #[cfg(not(unix))]
    let _ = leader;
}

/// Fills in one word, from left to right.
fn fill_word(word: &str, values: &[OsString; 7]) -> OsString {
    let mut filled = OsString::new();
    let mut rest = word;
    while let Some(at) = rest.find('{') {
        filled.push(&rest[..at]);
        rest = &rest[at..];
        match PLACES.iter().zip(values).find(|((place, _), _)| rest.starts_with(place)) {
            Some(((place, _), value)) => {
                filled.push::<&OsStr>(value);
                rest = &rest[place.len()..];
            }
            None => {
                filled.push("{");
                rest = &rest[1..];
            }
        }
    }
    filled.push(rest);
    filled
}

/// The end of what a program said.
fn quote(said: &mut File) -> String {
    let length = said.metadata().map_or(0, |m| m.len());
    let mut bytes = Vec::new();
    let read = said
        .seek(SeekFrom::Start(length.saturating_sub(MOST_SAID)))
        .and_then(|_| said.read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes);
    match (read, text.trim()) {
        (Err(_), _) | (_, "") => String::new(),
        (_, text) => format!(":\n{text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::Case;

    const MINUTE: Duration = Duration::from_secs(60);

    fn case(folder: &Path) -> Case {
        let text = "title = \"a\"\ntests = []\nwidth = 4\nheight = 2\nspp = 1\n[[expect]]\nname = \"a\"\nmean = [1, 1, 1]\n\
                    source = \"\"\ntolerance = 0\nwhy = \"\"";
        std::fs::write(folder.join("expect.toml"), text).expect("written");
        Case::load(folder).expect("a case")
    }

    fn run(template: &str, timeout: Duration) -> Result<(), String> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let case = case(folder.path());
        let job = Job { case: &case, spp: 16, seed: 3 };
        let template = CommandTemplate::new(template, timeout).expect("a template");
        template.run(&job, &folder.path().join("with space.exr"), &|| false)
    }

    #[test]
    fn templates_without_input_output_or_size_are_refused() {
        for (template, says) in [
            ("", "empty"),
            ("a {input} {width} {height}", "{output}"),
            ("a '{input} {output} {width} {height}", "quote"),
        ] {
            let message = CommandTemplate::new(template, MINUTE).expect_err(template).to_string();
            assert!(message.contains(says), "{message}");
        }
    }

    #[test]
    fn words_stay_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let case = case(folder.path());
        let job = Job { case: &case, spp: 16, seed: 3 };
        let text = "a 'b c' --size={width}x{height} {input} -o{output} {spp}/{seed} {environment} {other} {";
        let words =
            CommandTemplate::new(text, MINUTE).expect("a template").fill(&job, Path::new("/x y/{seed}.exr"));
        assert_eq!(words[..3], ["a", "b c", "--size=4x2"]);
        assert_eq!(words[4..], ["-o/x y/{seed}.exr", "16/3", "0,0,0", "{other}", "{"]);
    }

    #[test]
    fn failures_say_what_the_program_said() {
        let all = "{input} {output} {width} {height}";
        assert_eq!(run(&format!("sh -c 'touch \"$2\"' x {all}"), MINUTE), Ok(()));
        let message =
            run(&format!("sh -c 'echo no licence >&2; exit 3' x {all}"), MINUTE).expect_err("fails");
        assert!(message.contains('3') && message.contains("no licence"), "{message}");
        let message = run(&format!("sh -c 'echo done' x {all}"), MINUTE).expect_err("writes nothing");
        assert!(message.contains("no picture") && message.contains("done"), "{message}");
        let message = run(&format!("/no/such/program {all}"), MINUTE).expect_err("is not there");
        assert!(message.contains("cannot start"), "{message}");
        let message =
            run(&format!("sh -c 'exec sleep 60' x {all}"), Duration::from_millis(50)).expect_err("hangs");
        assert!(message.contains("not finished after 0.05 s"), "{message}");
    }

    /// What a script has started ends with it: nothing writes the file after a while.
    #[cfg(unix)]
    #[test]
    fn what_hangs_ends_with_all_that_it_started() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let late = folder.path().join("late");
        let script = format!("(sleep 1; touch {}) & wait", late.display());
        let template = format!("sh -c '{script}' x {{input}} {{output}} {{width}} {{height}}");
        run(&template, Duration::from_millis(200)).expect_err("hangs");
        std::thread::sleep(Duration::from_millis(1500));
        assert!(!late.exists());
    }
}
