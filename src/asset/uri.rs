//! URIs: `data:` payloads, and files that must lie in the asset's own folder.
//!
//! A glTF file may come from anywhere, so a URI is a relative path below the folder of the document and nothing else:
//! no `..` that climbs out, no absolute path, no scheme, no symbolic link that leads away, and only regular files
//! (a device could be endless). [`LoadOptions::allow_outside`](super::LoadOptions::allow_outside) lifts the first
//! restrictions, not the last.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use serde_json::Value;

use super::error::{AssetError, shorten};
use super::spelling::{self, Twin};

/// Base64 as found in the wild: with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The longest URI of a file that is tried; file systems have shorter limits.
const LONGEST_PATH: usize = 4096;

/// A payload read from a URI, with what was odd about the URI.
pub(crate) struct Payload {
    pub bytes: Vec<u8>,
    pub oddity: Option<String>,
}

fn refuse(pointer: &str, uri: &str, message: impl Into<String>) -> AssetError {
    AssetError::Uri {
        pointer: pointer.to_owned(),
        uri: uri.to_owned(),
        message: message.into(),
        advice: None,
    }
}

/// Decodes a `data:` URI (RFC 2397); `None` if `uri` is not one.
pub(crate) fn data(pointer: &str, uri: &str) -> Option<Result<Payload, AssetError>> {
    let rest = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).map(|_| &uri[5..])?;
    let Some((head, body)) = rest.split_once(',') else {
        return Some(Err(refuse(pointer, uri, "the data URI has no comma")));
    };
    if !head.to_ascii_lowercase().ends_with(";base64") {
        let bytes = percent_decode_str(body).collect();
        let oddity = Some("the data URI is not base64, as glTF requires".to_owned());
        return Some(Ok(Payload { bytes, oddity }));
    }
    let decoded = if body.bytes().any(|b| b == b'%' || b.is_ascii_whitespace()) {
        let clean: Vec<u8> = percent_decode_str(body).filter(|b| !b.is_ascii_whitespace()).collect();
        BASE64.decode(clean)
    } else {
        BASE64.decode(body)
    };
    Some(match decoded {
        Ok(bytes) => Ok(Payload { bytes, oddity: None }),
        Err(e) => Err(refuse(pointer, uri, format!("the data URI is not valid base64 ({e})"))),
    })
}

/// Reads the file a URI names.
///
/// The percent-decoded path is tried first; then, since exporters get this wrong, the path as written, without a
/// query or fragment, and with backslashes as separators; then names whose letters are composed otherwise.
pub(crate) fn file(
    base: &Path,
    pointer: &str,
    uri: &str,
    allow_outside: bool,
    limit: u64,
) -> Result<Payload, AssetError> {
    if uri.is_empty() {
        return Err(refuse(pointer, uri, "the URI is empty"));
    }
    if uri.len() > LONGEST_PATH {
        return Err(refuse(pointer, uri, "the URI is too long for the name of a file"));
    }
    let decoded = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let bare = uri.split(['?', '#']).next().unwrap_or_default();
    let candidates = [
        (decoded.clone(), None),
        (uri.to_owned(), Some("the URI is not percent-encoded")),
        (
            percent_decode_str(bare).decode_utf8_lossy().into_owned(),
            Some("the query or fragment of the URI is ignored"),
        ),
        (decoded.replace('\\', "/"), Some("the URI separates folders with backslashes")),
    ];
    let mut missing = None;
    let mut twins = Vec::new();
    let mut tried: Vec<&str> = Vec::new();
    for (path, oddity) in &candidates {
        if path.is_empty() || tried.contains(&path.as_str()) {
            continue;
        }
        tried.push(path);
        let path = locate(base, path, allow_outside).map_err(|why| {
            refuse(pointer, uri, why).with_advice(
                "if the file is to be trusted, allow it to name files outside (`--allow-outside`)",
            )
        })?;
        match read(base, &path, allow_outside, limit) {
            Ok(bytes) => return Ok(Payload { bytes, oddity: oddity.map(str::to_owned) }),
            Err(ReadError::Missing(source)) => {
                twins.extend(spelling::twin(base, &path));
                missing.get_or_insert((path, source));
            }
            Err(e) => return Err(unreadable(pointer, uri, path, e, limit)),
        }
    }
    let Some((path, source)) = missing else { return Err(refuse(pointer, uri, "the URI names no file")) };
    // Of the ways to read the URI, one that differs in composition alone is the best.
    twins.sort_by_key(|twin| matches!(twin, Twin::Case(_)));
    match twins.into_iter().next() {
        None => Err(AssetError::Io { pointer: pointer.to_owned(), path, source }),
        Some(Twin::Composition(path)) => match read(base, &path, allow_outside, limit) {
            Ok(bytes) => Ok(Payload { bytes, oddity: None }),
            Err(e) => Err(unreadable(pointer, uri, path, e, limit)),
        },
        Some(Twin::Case(path)) => {
            let path = path.strip_prefix(base).unwrap_or(&path);
            let there = shorten(&path.to_string_lossy());
            Err(refuse(pointer, uri, "there is no such file").with_advice(format!(
                "`{there}` is there, which differs in case: rename it, or mend the URI"
            )))
        }
    }
}

fn unreadable(pointer: &str, uri: &str, path: PathBuf, error: ReadError, limit: u64) -> AssetError {
    match error {
        ReadError::Missing(source) | ReadError::Other(source) => {
            AssetError::Io { pointer: pointer.to_owned(), path, source }
        }
        ReadError::Refused(why) => refuse(pointer, uri, why),
        ReadError::TooLarge(needed) => AssetError::Limit {
            pointer: pointer.to_owned(),
            what: "the file, in bytes,".to_owned(),
            needed,
            limit,
            field: "file_bytes",
        },
    }
}

/// Every `uri` of a document that names a file, with its JSON pointer.
pub(crate) fn named_in(document: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut stack = vec![(document, String::new())];
    while let Some((value, pointer)) = stack.pop() {
        match value {
            Value::Array(items) => {
                let items = items.iter().enumerate().filter(|(_, v)| v.is_object() || v.is_array());
                stack.extend(items.rev().map(|(i, v)| (v, format!("{pointer}/{i}"))));
            }
            Value::Object(members) => {
                if let Some(uri) = members.get("uri").and_then(Value::as_str)
                    && !uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
                {
                    found.push((format!("{pointer}/uri"), uri.to_owned()));
                }
                let items = members.iter().filter(|(k, v)| *k != "extras" && (v.is_object() || v.is_array()));
                stack.extend(items.rev().map(|(k, v)| (v, format!("{pointer}/{k}"))));
            }
            _ => {}
        }
    }
    found
}

/// The paths that a URI may mean, whether or not there are files.
pub(crate) fn candidates(base: &Path, uri: &str) -> [PathBuf; 2] {
    let decoded = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    [decoded, uri.to_owned()].map(|path| base.join(path))
}

/// The path of a decoded URI, or why it is refused.
fn locate(base: &Path, path: &str, allow_outside: bool) -> Result<PathBuf, String> {
    if path.contains('\0') {
        return Err("the URI contains a zero byte".to_owned());
    }
    let scheme = path.split(['/', '\\']).next().and_then(|first| first.split_once(':')).map(|(s, _)| s);
    if let Some(scheme) = scheme {
        let is_drive = scheme.len() == 1;
        let local = path.strip_prefix("file://").filter(|_| allow_outside);
        return match local {
            Some(local) => Ok(PathBuf::from(local)),
            None if is_drive && allow_outside => Ok(PathBuf::from(path)),
            None if is_drive || scheme == "file" => Err("the URI is not relative".to_owned()),
            None => Err(format!("URIs of the scheme `{scheme}:` are not read")),
        };
    }
    if allow_outside {
        return Ok(base.join(path));
    }
    if path.starts_with(['/', '\\']) {
        return Err("the URI is an absolute path".to_owned());
    }
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop().ok_or("the URI leads out of the asset's folder")?;
            }
            part if part.split('\\').any(|p| p == "..") => {
                return Err("the URI leads out of the asset's folder".to_owned());
            }
            part => parts.push(part),
        }
    }
    Ok(base.join(parts.iter().collect::<PathBuf>()))
}

enum ReadError {
    Missing(std::io::Error),
    Other(std::io::Error),
    Refused(String),
    TooLarge(u64),
}

fn read(base: &Path, path: &Path, allow_outside: bool, limit: u64) -> Result<Vec<u8>, ReadError> {
    let classify = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory => ReadError::Missing(e),
        _ => ReadError::Other(e),
    };
    let real = path.canonicalize().map_err(classify)?;
    if !allow_outside {
        let base = if base.as_os_str().is_empty() { Path::new(".") } else { base };
        let base = base.canonicalize().map_err(classify)?;
        if !real.starts_with(&base) {
            return Err(ReadError::Refused("a symbolic link leads out of the asset's folder".to_owned()));
        }
    }
    read_regular(&real, limit).map_err(|e| match e {
        ReadError::Other(e) => classify(e),
        e => e,
    })
}

fn read_regular(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    let metadata = std::fs::metadata(path).map_err(ReadError::Other)?;
    if !metadata.is_file() {
        return Err(ReadError::Refused("not a regular file".to_owned()));
    }
    if metadata.len() > limit {
        return Err(ReadError::TooLarge(metadata.len()));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0));
    let file = File::open(path).map_err(ReadError::Other)?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(ReadError::Other)?;
    if bytes.len() as u64 > limit {
        return Err(ReadError::TooLarge(bytes.len() as u64));
    }
    Ok(bytes)
}

/// What is said of a relative URI in a document that came from a stream.
pub(crate) fn without_folder(pointer: &str, uri: &str) -> AssetError {
    refuse(pointer, uri, "the document came from a stream, and so has no folder that this file could lie in")
        .with_advice("give the path of the file instead, or pack everything into one .glb")
}

/// Reads a document from a stream to its end.
pub(crate) fn stream(stream: impl Read, limit: u64) -> Result<Vec<u8>, AssetError> {
    let mut bytes = Vec::new();
    stream.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|source| AssetError::Io {
        pointer: String::new(),
        path: PathBuf::from("standard input"),
        source,
    })?;
    if bytes.len() as u64 > limit {
        return Err(AssetError::Limit {
            pointer: String::new(),
            what: "the document, in bytes,".to_owned(),
            needed: bytes.len() as u64,
            limit,
            field: "file_bytes",
        });
    }
    Ok(bytes)
}

/// Reads the document itself.
pub(crate) fn document(path: &Path, limit: u64) -> Result<Vec<u8>, AssetError> {
    let io = |source| AssetError::Io { pointer: String::new(), path: path.to_owned(), source };
    read_regular(path, limit).map_err(|e| match e {
        ReadError::Missing(e) | ReadError::Other(e) => io(e),
        ReadError::Refused(why) => {
            AssetError::Container { message: format!("{}: {why}", path.display()), advice: None }
        }
        ReadError::TooLarge(needed) => AssetError::Limit {
            pointer: String::new(),
            what: "the file, in bytes,".to_owned(),
            needed,
            limit,
            field: "file_bytes",
        },
    })
}
