//! The bodies of the fuzz targets (`fuzz/`) over their corpus and over mutations of it, and documents that are generated
//! from scratch: each loads or errs, soon, in little memory, without a panic.

mod documents;
mod everywhere;
#[path = "../../fuzz/src/lib.rs"]
#[allow(dead_code, reason = "libFuzzer's side is used by the targets only")]
mod fuzzing;

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A file of some kilobytes is read and rendered in milliseconds; the rest is for machines that do something else besides.
const LONGEST: Duration = Duration::from_secs(5);

/// The limits of the bodies allow some tens of megabytes for each of the threads that run tests.
const MOST_MEMORY: u64 = 1 << 30;

/// The most memory that this process ever had, in bytes; `None` where the system does not say.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(1024 * line.trim().trim_end_matches(" kB").parse::<u64>().ok()?)
}

/// Runs a body within the bounds of time and memory; what it returns.
#[track_caller]
fn bounded(what: &str, run: impl FnOnce() -> bool) -> bool {
    let start = Instant::now();
    let read = run();
    let seconds = start.elapsed();
    assert!(seconds < LONGEST, "{what} took {seconds:?}");
    assert!(peak_memory().is_none_or(|bytes| bytes < MOST_MEMORY), "{what}: {:?} bytes", peak_memory());
    read
}

/// The files of a corpus, by name.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&folder).expect("the corpus is there");
    let mut files: Vec<_> = entries
        .map(|e| e.expect("an entry").path())
        .map(|path| (path.display().to_string(), std::fs::read(&path).expect("a readable file")))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    files
}

/// Runs a body over a corpus and over chains of mutations that begin at each file of it. At least `share` of the mutated
/// files must be such as can be read, else mutations break what they should bend.
fn smoke(
    target: &str,
    body: fn(&[u8]) -> bool,
    mutate: fn(&[u8], u64) -> Option<Vec<u8>>,
    mutations: usize,
    share: f64,
) {
    /// Mutations of mutations: beyond that little is left that loads.
    const CHAIN: u64 = 4;
    let files = corpus(target);
    let chains = mutations / (files.len() * CHAIN as usize);
    let (mut read, mut all) = (0, 0);
    for (name, bytes) in files {
        bounded(&name, || body(&bytes));
        for chain in 0..chains as u64 {
            let mut bytes = bytes.clone();
            for link in 0..CHAIN {
                let Some(next) = mutate(&bytes, CHAIN * chain + link) else { break };
                bytes = next;
                read +=
                    usize::from(bounded(&format!("chain {chain}, link {link} of {name}"), || body(&bytes)));
                all += 1;
            }
        }
    }
    println!("{target}: {read} of {all} mutated files are read");
    assert!(read as f64 > share * all as f64, "{target}: only {read} of {all} mutated files are read");
}

#[test]
fn mutated_files_end_well() {
    smoke("loader", fuzzing::loader, fuzzing::mutate::loader, 3_000, 0.15);
}

#[test]
fn mutated_materials_end_well() {
    smoke("extensions", fuzzing::extensions, fuzzing::mutate::extensions, 4_000, 0.2);
}

#[test]
fn mutated_payloads_end_well() {
    smoke("payloads", fuzzing::payloads, fuzzing::mutate::payloads, 10_000, 0.3);
}

#[test]
fn mutated_environments_end_well() {
    smoke("environments", fuzzing::environments, fuzzing::mutate::environments, 10_000, 0.1);
}
