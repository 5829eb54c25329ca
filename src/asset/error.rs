//! What can go wrong while loading, and what is worth telling: errors end the load, diagnostics do not.
//!
//! Both name the place in the document as a JSON pointer (RFC 6901) and, where there is something to do about it, say
//! what. An error is something that leaves no sensible picture (a broken container, data that is not there); whatever
//! a viewer would shrug off becomes a [`Diagnostic`].

use std::path::PathBuf;

use serde::Serialize;

/// How much a [`Diagnostic`] matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file is right, and something of it is not used.
    Note,
    /// The file is wrong or doubtful, and the picture may not show what was meant.
    Warning,
    /// Part of the file could not be used at all.
    Error,
}

/// Something worth telling about a file that was loaded all the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// How much it matters.
    pub severity: Severity,
    /// JSON pointer into the glTF document; empty for the file as a whole.
    pub pointer: String,
    /// What is the case.
    pub message: String,
    /// What could be done about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<String>,
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.pointer.is_empty() {
            write!(f, "{}: ", self.pointer)?;
        }
        f.write_str(&self.message)?;
        match &self.advice {
            Some(advice) => write!(f, " ({advice})"),
            None => Ok(()),
        }
    }
}

/// Why a file could not be loaded, sorted by what the caller can do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AssetError {
    /// A file could not be read.
    #[error("{}{}: {source}", prefix(pointer), path.display())]
    Io {
        /// Where the document refers to the file; empty for the document itself.
        pointer: String,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not glTF 2.0 at all, or its GLB container is broken.
    #[error("{message}")]
    Container {
        /// What is wrong.
        message: String,
        /// What could be done.
        advice: Option<String>,
    },
    /// The document is not JSON.
    #[error("the glTF document is not valid JSON: {message} (line {line}, column {column})")]
    Json {
        /// What the parser said.
        message: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// The document says something that cannot be.
    #[error("{}{message}", prefix(pointer))]
    Invalid {
        /// Where.
        pointer: String,
        /// What is wrong.
        message: String,
        /// What could be done.
        advice: Option<String>,
    },
    /// The file needs extensions that this program does not have.
    #[error("/extensionsRequired: the file requires {}, which nephrite does not support", names.join(", "))]
    RequiredExtension {
        /// Every one of them.
        names: Vec<String>,
    },
    /// A URI that will not be followed: it leaves the asset's folder, or needs a network.
    #[error("{}{message}: {}", prefix(pointer), shorten(uri))]
    Uri {
        /// Where.
        pointer: String,
        /// The URI as written.
        uri: String,
        /// Why not.
        message: String,
        /// What could be done.
        advice: Option<String>,
    },
    /// The file asks for more than [`Limits`](crate::asset::Limits) allows.
    #[error("{}{what} needs {needed}, and the limit is {limit}", prefix(pointer))]
    Limit {
        /// Where.
        pointer: String,
        /// What is being counted, with its unit.
        what: String,
        /// How much the file asks for.
        needed: u64,
        /// How much is allowed.
        limit: u64,
        /// The field of [`Limits`](crate::asset::Limits) that can be raised.
        field: &'static str,
    },
    /// There is no memory for what the file asks for, although the limits allow it.
    #[error("{}{what} needs {:.1} GB of memory, which are not there", prefix(pointer), *needed as f64 / 1e9)]
    Memory {
        /// Where.
        pointer: String,
        /// What needs it.
        what: &'static str,
        /// How many bytes.
        needed: u64,
    },
    /// A strict load met something that would otherwise be a warning.
    #[error("{0}")]
    Strict(Diagnostic),
}

impl AssetError {
    /// An [`AssetError::Invalid`] without advice.
    pub fn invalid(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { pointer: pointer.into(), message: message.into(), advice: None }
    }

    /// The same error with advice, where its kind carries any.
    pub fn with_advice(mut self, text: impl Into<String>) -> Self {
        match &mut self {
            Self::Invalid { advice, .. } | Self::Uri { advice, .. } | Self::Container { advice, .. } => {
                *advice = Some(text.into());
            }
            _ => {}
        }
        self
    }

    /// JSON pointer of the place in the document; empty where it is the file as a whole.
    pub fn pointer(&self) -> &str {
        match self {
            Self::Io { pointer, .. }
            | Self::Invalid { pointer, .. }
            | Self::Uri { pointer, .. }
            | Self::Limit { pointer, .. }
            | Self::Memory { pointer, .. } => pointer,
            Self::RequiredExtension { .. } => "/extensionsRequired",
            Self::Strict(diagnostic) => &diagnostic.pointer,
            Self::Container { .. } | Self::Json { .. } => "",
        }
    }

    /// What is wrong, without the place.
    pub fn message(&self) -> String {
        let text = self.to_string();
        let prefix = prefix(self.pointer());
        text.strip_prefix(&prefix).map_or(text.clone(), str::to_owned)
    }

    /// What the user could do about it.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::Invalid { advice, .. } | Self::Uri { advice, .. } | Self::Container { advice, .. } => {
                advice.clone()
            }
            Self::RequiredExtension { .. } => {
                Some("export the asset again without these extensions, or convert it".to_owned())
            }
            Self::Limit { field, .. } => Some(crate::scene::raise_limit(field)),
            Self::Strict(diagnostic) => diagnostic.advice.clone(),
            Self::Io { .. } | Self::Json { .. } | Self::Memory { .. } => None,
        }
    }
}

fn prefix(pointer: &str) -> String {
    if pointer.is_empty() { String::new() } else { format!("{pointer}: ") }
}

/// “1 vertex”, “2 vertices”.
pub(crate) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Text from a file, cut to what a message can bear and free of control characters.
pub(crate) fn shorten(text: &str) -> String {
    const LONGEST: usize = 120;
    let mut short: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}
