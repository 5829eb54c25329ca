//! Numbers of things in sentences.

use std::fmt::Display;

/// “1 vertex”, “2 vertices”.
pub(crate) fn count<N: Display + PartialEq + From<u8>>(n: N, one: &str, many: &str) -> String {
    let what = if n == N::from(1) { one } else { many };
    format!("{n} {what}")
}
