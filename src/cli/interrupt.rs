//! Ctrl-C: the first one asks the render to stop after the current pass, the second one ends the program.

use super::Failure;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Exit code of an interrupted program, 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// Starts listening.
pub(super) fn install() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        eprintln!("\nstopping; what is finished will be written (interrupt again to stop at once)");
    })
    .map_err(|e| Failure::cannot(format!("cannot listen for interrupts: {e}")))
}

/// Whether somebody asked to stop.
pub(super) fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Fails if somebody asked to stop, for the places between two pieces of work.
pub(super) fn check() -> Result<(), Failure> {
    if requested() { Err(Failure::Interrupted) } else { Ok(()) }
}
