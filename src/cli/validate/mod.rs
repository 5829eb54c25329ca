//! `nephrite validate`: what is wrong with the media of files; ends with 1 if anything is.

use super::Failure;
use super::args::LoadArgs;
use super::author_args::ValidateArgs;
use super::authored;
use super::documents::{Documents, shown};
use super::message::{also_in, count, grouped, printable, write_out};
use super::pipeline::load_options;
use crate::asset::{Diagnostic, LoadOptions, Severity};
use crate::author::check;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// What was found in one file.
struct Checked {
    file: String,
    found: Vec<Diagnostic>,
}

/// Validates as the arguments say.
pub(super) fn run(args: &ValidateArgs) -> Result<(), Failure> {
    let all = Documents::all(&args.load.input)?;
    let mut reports = Vec::new();
    let mut is_first = true;
    let result = all.each(|document| {
        let load = LoadArgs { input: document.to_owned(), ..args.load.clone() };
        let checked = Checked::new(&load, args.scene)?;
        if args.json {
            reports.push(checked.json());
        } else {
            let between = if std::mem::take(&mut is_first) { "" } else { "\n" };
            write_out(&format!("{between}{}", checked.text()))?;
        }
        match checked.number(Severity::Error) {
            0 => Ok(()),
            n => Err(Failure::cannot(format!("{} has {}", checked.file, count(n as u64, "error", "errors")))),
        }
    });
    let report = if all.are_several() { Some(Value::Array(reports)) } else { reports.pop() };
    if let Some(report) = report.filter(|_| args.json) {
        write_out(&format!("{report:#}\n"))?;
    }
    result
}

impl Checked {
    fn new(args: &LoadArgs, scene: Option<usize>) -> Result<Self, Failure> {
        let options = load_options(args, LoadOptions { scene, ..Default::default() });
        let file = authored::read(args, &options)?;
        let loaded = authored::load(args, file.bytes(), &options);
        Ok(Self { file: shown(&args.input), found: check::check(&file, loaded.as_ref()) })
    }

    fn number(&self, severity: Severity) -> usize {
        self.found.iter().filter(|d| d.severity == severity).count()
    }

    fn json(&self) -> Value {
        json!({
            "file": self.file,
            "valid": self.number(Severity::Error) == 0,
            "errors": self.number(Severity::Error),
            "warnings": self.number(Severity::Warning),
            "notes": self.number(Severity::Note),
            "findings": self.found,
        })
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for (diagnostic, more) in grouped(&self.found) {
            let kind = match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
            let more = if more > 0 { also_in(more) } else { String::new() };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{kind}: {}{more}", printable(&diagnostic.to_string()));
        }
        let numbers = [(Severity::Error, "error"), (Severity::Warning, "warning"), (Severity::Note, "note")];
        let numbers = numbers.map(|(s, name)| count(self.number(s) as u64, name, &format!("{name}s")));
        let _ = writeln!(text, "{}: {}", printable(&self.file), numbers.join(", "));
        text
    }
}
