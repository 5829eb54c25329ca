//! `nephrite validate`: what is wrong with the media of a file; ends with 1 if anything is.

use super::Failure;
use super::author_args::ValidateArgs;
use super::authored::cannot_read;
use super::message::{also_in, grouped, printable};
use crate::asset::{LoadOptions, Severity, load_bytes};
use crate::author::{AuthoredFile, check};
use crate::film::atomic::directory_of;
use serde_json::json;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};

/// Validates as the arguments say.
pub(super) fn run(args: &ValidateArgs) -> Result<(), Failure> {
    let options =
        LoadOptions { scene: args.scene, weld_tolerance: args.weld_tolerance, ..Default::default() };
    let file = AuthoredFile::read(&args.input, &options.limits).map_err(|e| cannot_read(&args.input, &e))?;
    let loaded = load_bytes(file.bytes().to_vec(), &directory_of(&args.input), &options);
    let found = check::check(&file, loaded.as_ref());
    let count = |severity: Severity| found.iter().filter(|d| d.severity == severity).count();
    let [errors, warnings, notes] = [Severity::Error, Severity::Warning, Severity::Note].map(count);
    let mut text = String::new();
    if args.json {
        let report = json!({
            "file": args.input.to_string_lossy(),
            "valid": errors == 0,
            "errors": errors,
            "warnings": warnings,
            "notes": notes,
            "findings": found,
        });
        text = format!("{report:#}\n");
    } else {
        for (diagnostic, more) in grouped(&found) {
            let kind = match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
            let more = if more > 0 { also_in(more) } else { String::new() };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{kind}: {}{more}", printable(&diagnostic.to_string()));
        }
        let file = args.input.display().to_string();
        let _ = writeln!(text, "{}: {}", printable(&file), counted([errors, warnings, notes]));
    }
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => return Err(Failure::cannot(error)),
        _ => {}
    }
    match errors {
        0 => Ok(()),
        1 => Err(Failure::cannot(format!("{} has 1 error", args.input.display()))),
        n => Err(Failure::cannot(format!("{} has {n} errors", args.input.display()))),
    }
}

/// “1 error, 2 warnings, 0 notes”.
fn counted(counts: [usize; 3]) -> String {
    let named = counts.into_iter().zip(["error", "warning", "note"]);
    let named = named.map(|(n, what)| format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
    named.collect::<Vec<_>>().join(", ")
}
