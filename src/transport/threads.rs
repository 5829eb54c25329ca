//! The threads that work: those of one pool, which everything shares, unless another number is asked for.

use super::control::RenderError;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::error::Error as _;
use std::sync::OnceLock;

/// Threads to work on.
pub(super) struct Workers {
    /// `None` for those of the pool that is there.
    pool: Option<ThreadPool>,
}

impl Workers {
    /// So many threads, 0 for those of the pool that is there.
    pub fn new(threads: usize) -> Result<Self, RenderError> {
        let failed = |reason| RenderError::Threads {
            threads: match threads {
                0 => std::thread::available_parallelism().map_or(1, usize::from),
                n => n,
            },
            reason,
        };
        if rayon::current_thread_index().is_none() {
            ensure_shared().map_err(failed)?;
        }
        if threads == 0 || threads == rayon::current_num_threads() {
            return Ok(Self { pool: None });
        }
        let pool =
            ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| failed(e.to_string()))?;
        Ok(Self { pool: Some(pool) })
    }

    /// Does something on them.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// Makes the shared pool unless there is one: whoever uses it without would panic where the system gives no threads.
fn ensure_shared() -> Result<(), String> {
    static SHARED: OnceLock<Result<(), String>> = OnceLock::new();
    SHARED
        .get_or_init(|| match ThreadPoolBuilder::new().build_global() {
            // One that is there already is an error without a source.
            Err(error) if error.source().is_some() => Err(error.to_string()),
            _ => Ok(()),
        })
        .clone()
}
