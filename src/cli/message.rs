//! What is said on standard error: notes, warnings and errors, each once.

use super::Failure;
use super::pipeline::{Diagnostic, Severity};
use std::borrow::Cow;
use std::collections::HashSet;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;

/// Says things once.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    quiet: bool,
    /// The file that everything is about, where there are several.
    of: Option<String>,
    said: Mutex<HashSet<String>>,
}

impl Reporter {
    /// A reporter; a quiet one keeps notes to itself.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, ..Self::default() }
    }

    /// A reporter that names the file that it tells of, if one is given.
    pub fn of(quiet: bool, file: Option<&Path>) -> Self {
        Self { quiet, of: file.map(|path| path.display().to_string()), ..Self::default() }
    }

    pub fn note(&self, text: impl AsRef<str>) {
        if !self.quiet {
            self.once("note", NOTE, text.as_ref());
        }
    }

    pub fn warning(&self, text: impl AsRef<str>) {
        self.once("warning", WARNING, text.as_ref());
    }

    /// Says what the loader found. The same finding in many places is said once, with their number.
    pub fn diagnostics(&self, found: &[Diagnostic]) {
        for (diagnostic, more) in grouped(found) {
            let mut text = diagnostic.to_string();
            if more > 0 {
                text += &also_in(more);
            }
            match diagnostic.severity {
                Severity::Note => self.note(text),
                Severity::Warning => self.warning(text),
                Severity::Error => self.once("error", ERROR, &text),
            }
        }
    }

    fn once(&self, label: &str, color: &str, text: &str) {
        let mut said = match self.said.lock() {
            Ok(said) => said,
            Err(poisoned) => poisoned.into_inner(),
        };
        let text = match &self.of {
            Some(file) if !text.contains(file) => Cow::Owned(format!("{file}: {text}")),
            _ => Cow::Borrowed(text),
        };
        if said.insert(format!("{label}{text}")) {
            say(label, color, &text);
        }
    }
}

/// Each finding with the number of further ones that differ only in where they are, in order of first appearance.
pub(super) fn grouped(found: &[Diagnostic]) -> Vec<(&Diagnostic, usize)> {
    let mut groups: Vec<(&Diagnostic, usize)> = Vec::new();
    let mut index = std::collections::HashMap::new();
    for diagnostic in found {
        let key = (diagnostic.severity, &diagnostic.message, &diagnostic.advice);
        match index.get(&key) {
            Some(&at) => {
                let group: &mut (&Diagnostic, usize) = &mut groups[at];
                group.1 += 1;
            }
            None => {
                index.insert(key, groups.len());
                groups.push((diagnostic, 0));
            }
        }
    }
    groups
}

/// “ [and in 2 more places]”
pub(super) fn also_in(more: usize) -> String {
    format!(" [and in {}]", count(more as u64, "more place", "more places"))
}

/// “1 path was”, “2 paths were”.
pub(super) fn count(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Says why the program stops, and what to do.
pub(super) fn error(text: &str, advice: Option<&str>) {
    say("error", ERROR, text);
    if let Some(advice) = advice {
        say("  help", NOTE, advice);
    }
}

const ERROR: &str = "\x1b[1;31m";
const WARNING: &str = "\x1b[1;33m";
const NOTE: &str = "\x1b[1;36m";

fn say(label: &str, color: &str, text: &str) {
    let mut stderr = std::io::stderr().lock();
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    let able = std::env::var_os("TERM").is_none_or(|term| term != "dumb");
    let text = printable(text);
    // A closed standard error is no reason to stop rendering.
    let _ = if wanted && able && stderr.is_terminal() {
        writeln!(stderr, "{color}{label}:\x1b[0m {text}")
    } else {
        writeln!(stderr, "{label}: {text}")
    };
}

/// Writes a line of ours, which no file has a part in, to standard error.
pub(super) fn line(text: &str) {
    // As in [`say`].
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Writes a text of a command's own to standard output, of which whoever reads it may not want all.
///
/// # Errors
/// Where it cannot be written for another reason.
pub(super) fn write_out(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::cannot(error)),
        _ => Ok(()),
    }
}

/// Writes a line to standard output, if anybody reads that.
pub(super) fn print(text: &str) {
    // What is said there is also in the exit code and the files.
    let _ = writeln!(std::io::stdout().lock(), "{}", printable(text));
}

/// Text without what would move the cursor, change colours, or look like a line of another kind: control characters are
/// escaped as in Rust's strings, and so are those that turn the direction of writing.
pub(super) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_unprintable(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// Controls (C0, DEL, C1), separators of lines and paragraphs, and marks that turn the direction of writing.
fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_findings_in_many_places_are_one() {
        let finding = |pointer: &str, message: &str| Diagnostic {
            severity: Severity::Warning,
            pointer: pointer.to_owned(),
            message: message.to_owned(),
            advice: None,
        };
        let found = [finding("/a/0", "x"), finding("/a/1", "y"), finding("/a/2", "x"), finding("/a/3", "x")];
        let groups = grouped(&found);
        let brief: Vec<_> =
            groups.iter().map(|(d, n)| (d.pointer.as_str(), d.message.as_str(), *n)).collect();
        assert_eq!(brief, [("/a/0", "x", 2), ("/a/1", "y", 0)]);
    }
}
