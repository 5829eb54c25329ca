//! The threads that work: those of one pool, which everything shares, unless another number is asked for.

use std::error::Error as _;
use std::sync::OnceLock;

/// Does something on so many threads, 0 for those of the pool that is there. The error says why there are none.
pub(super) fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, String> {
    if rayon::current_thread_index().is_none() {
        ensure_shared()?;
    }
    if threads == 0 || threads == rayon::current_num_threads() {
        return Ok(work());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|e| e.to_string())?.install(work))
}

/// Makes the shared pool unless there is one: whoever uses it without would panic where the system gives no threads.
fn ensure_shared() -> Result<(), String> {
    static SHARED: OnceLock<Result<(), String>> = OnceLock::new();
    SHARED
        .get_or_init(|| match rayon::ThreadPoolBuilder::new().build_global() {
            // One that is there already is an error without a source.
            Err(error) if error.source().is_some() => Err(error.to_string()),
            _ => Ok(()),
        })
        .clone()
}
