//! What is said where the command line cannot be read: besides what clap says, what other programs call our options, and
//! which help to read.

use super::args::Args;
use clap::CommandFactory;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;

/// What options are called elsewhere, and here.
const ELSEWHERE: [(&str, &str); 22] = [
    ("samples", "spp"),
    ("sample-count", "spp"),
    ("samples-per-pixel", "spp"),
    ("resolution", "size"),
    ("res", "size"),
    ("width", "size"),
    ("height", "size"),
    ("out", "output"),
    ("out-file", "output"),
    ("output-file", "output"),
    ("hdri", "env"),
    ("envmap", "env"),
    ("environment", "env"),
    ("sky", "env"),
    ("bounces", "max-depth"),
    ("max-bounces", "max-depth"),
    ("depth", "max-depth"),
    ("integrator", "subsurface"),
    ("model", "subsurface"),
    ("tone-mapping", "tonemap"),
    ("time", "at"),
    ("transparent", "transparent-background"),
];

/// Says what is wrong with the command line, or what was asked for (`--help`, `--version`).
pub(super) fn tell(mut error: Error, typed: &[OsString]) -> ExitCode {
    if !error.use_stderr() {
        // Whoever asked for help may not read all of it.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let command = command_of(typed);
    if let Some(command) = &command {
        hint(&mut error, command);
    }
    let rendered = error.render();
    let mut stderr = std::io::stderr().lock();
    let able = std::env::var_os("TERM").is_none_or(|term| term != "dumb")
        && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    let mut text =
        if able && stderr.is_terminal() { rendered.ansi().to_string() } else { rendered.to_string() };
    if let (Some(command), Some(at)) = (command, text.rfind("--help")) {
        text.insert_str(at, &format!("nephrite {} ", command.get_name()));
    }
    // Standard error may be closed; there is nobody left to tell.
    let _ = stderr.write_all(text.as_bytes());
    ExitCode::from(2)
}

/// The command that was typed, if it is one.
fn command_of(typed: &[OsString]) -> Option<clap::Command> {
    let all = Args::command();
    typed.iter().skip(1).find_map(|word| all.find_subcommand(word)).cloned()
}

/// Adds what was probably meant.
fn hint(error: &mut Error, command: &clap::Command) {
    let Some(ContextValue::String(wrong)) = error.get(ContextKind::InvalidArg) else { return };
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let has = |name: &str| command.get_arguments().any(|argument| argument.get_long() == Some(name));
    match wrong.strip_prefix("--") {
        Some(name) => {
            let name = name.split('=').next().unwrap_or(name);
            let known = ELSEWHERE.iter().find(|(theirs, ours)| *theirs == name && has(ours));
            if let Some((_, ours)) = known {
                error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{ours}")));
            }
        }
        None if !wrong.starts_with('-') && has("output") => {
            let tip = StyledStr::from(format!("to write to {wrong}, give it after -o: -o {wrong}"));
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
        }
        None => {}
    }
}
