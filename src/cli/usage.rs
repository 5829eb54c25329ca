//! What is said where the command line cannot be read: besides what clap says, what was probably meant, and which help to
//! read.

use super::args::Args;
use super::elsewhere;
use clap::CommandFactory;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;

/// Joins values that begin with a minus to their options: `--exposure -1` is not two options, and neither is
/// `--absorption -3,1,1`, whose value is then refused for what it is.
pub(super) fn with_negative_numbers(typed: Vec<OsString>) -> Vec<OsString> {
    let Some(command) = command_of(&typed) else { return typed };
    let takes = |word: &str| {
        command.get_arguments().any(|argument| {
            let named = match word.strip_prefix("--") {
                Some(long) => argument.get_long() == Some(long),
                None => word.strip_prefix('-').is_some_and(|short| {
                    argument.get_short().is_some_and(|own| short.chars().eq(std::iter::once(own)))
                }),
            };
            named && argument.get_action().takes_values() && !argument.is_require_equals_set()
        })
    };
    let mut joined: Vec<OsString> = Vec::with_capacity(typed.len());
    let mut ended = false;
    for word in typed {
        ended |= word == "--";
        match (joined.last().and_then(|last| last.to_str()), word.to_str()) {
            (Some(option), Some(value)) if !ended && is_negative(value) && takes(option) => {
                let both = format!("{option}={value}");
                joined.pop();
                joined.push(both.into());
            }
            _ => joined.push(word),
        }
    }
    joined
}

/// Whether a word begins like a negative number.
fn is_negative(word: &str) -> bool {
    let rest = word.strip_prefix('-').unwrap_or("");
    let number = rest.strip_prefix('.').unwrap_or(rest);
    number.starts_with(|c: char| c.is_ascii_digit()) || ["inf", "nan"].contains(&&*rest.to_ascii_lowercase())
}

/// Says what is wrong with the command line, or what was asked for (`--help`, `--version`).
pub(super) fn tell(mut error: Error, typed: &[OsString]) -> ExitCode {
    if !error.use_stderr() {
        // Whoever asked for help may not read all of it.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let command = command_of(typed);
    match &command {
        Some(command) => hint(&mut error, command, typed),
        None => hint_of_command(&mut error),
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

/// Adds which command was probably meant.
fn hint_of_command(error: &mut Error) {
    let Some(ContextValue::String(wrong)) = error.get(ContextKind::InvalidSubcommand) else { return };
    if let Some(ours) = elsewhere::command(wrong) {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::String(ours.to_owned()));
    } else if [".gltf", ".glb"].iter().any(|end| wrong.to_ascii_lowercase().ends_with(end)) {
        tip(error, format!("a command comes first: nephrite render {wrong} -o FILE.png"));
    }
}

/// Adds what was probably meant.
fn hint(error: &mut Error, command: &clap::Command, typed: &[OsString]) {
    let Some(ContextValue::String(wrong)) = error.get(ContextKind::InvalidArg) else { return };
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let wrong = wrong.clone();
    let longs = || command.get_arguments().filter_map(|argument| argument.get_long());
    let has = |name: &str| longs().any(|long| long == name);
    let reads_a_file = command.get_arguments().any(|a| a.is_positional() && a.get_id() == "input");
    // An option with one dash, of which only the first letter is told.
    let dashed = || {
        let words = typed.iter().filter_map(|word| word.to_str());
        let names = words.filter(|word| word.starts_with(&wrong)).filter_map(|word| word.strip_prefix('-'));
        names.filter(|name| name.len() > 1).find_map(|name| Some(name.split('=').next()?.to_owned()))
    };
    let name = match wrong.strip_prefix("--") {
        Some(name) => Some(name.split('=').next().unwrap_or(name).to_owned()),
        None if wrong.starts_with('-') => dashed(),
        None => None,
    };
    if let Some(name) = name {
        if let Some(ours) = elsewhere::option(&name, longs()) {
            error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{ours}")));
        } else if reads_a_file && ["input", "in", "file", "gltf", "glb", "path"].contains(&name.as_str()) {
            let command = command.get_name();
            tip(error, format!("the file to read has no option: nephrite {command} FILE.glb"));
        }
    } else if !wrong.starts_with('-') {
        let is_picture = wrong.contains('.');
        if has("output") && (reads_a_file || is_picture) {
            tip(error, format!("to write to {wrong}, give it after -o: -o {wrong}"));
        } else if has("medium") {
            tip(error, format!("a medium is given after --medium: --medium {wrong}"));
        } else if reads_a_file {
            tip(error, "one file is read, or all in a folder: give the folder".to_owned());
        }
    }
}

/// Adds a sentence.
fn tip(error: &mut Error, text: String) {
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(text)]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_numbers_are_values() {
        let joined = |line: &str| {
            let words = with_negative_numbers(line.split(' ').map(OsString::from).collect());
            words.iter().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
        };
        for (typed, expected) in [
            ("nephrite render a.glb --exposure -1.5 -q", "nephrite render a.glb --exposure=-1.5 -q"),
            ("nephrite render a.glb --spp -1", "nephrite render a.glb --spp=-1"),
            ("nephrite edit a --absorption -3,1,1", "nephrite edit a --absorption=-3,1,1"),
            ("nephrite edit a -m -.5 --ior -inf", "nephrite edit a -m=-.5 --ior=-inf"),
            // Flags take no values, and options are none.
            ("nephrite render a -q -1", "nephrite render a -q -1"),
            ("nephrite render a --spp --size 4x4", "nephrite render a --spp --size 4x4"),
            ("nephrite render --spp -- -1", "nephrite render --spp -- -1"),
            ("-1 -1", "-1 -1"),
        ] {
            assert_eq!(joined(typed), expected);
        }
    }
}
