//! From bytes to a document: GLB chunks (glTF 2.0 §4) and JSON that reports duplicate keys.
//!
//! Both containers are told apart by their first bytes, not by the name of the file.

use std::fmt;
use std::ops::Range;

use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::error::{AssetError, count};

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// Where the parts of a file lie in its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parts {
    /// The JSON document.
    pub json: Range<usize>,
    /// The binary chunk of a GLB.
    pub bin: Option<Range<usize>>,
    /// What is odd about the container, but bearable.
    pub oddities: Vec<String>,
}

fn broken(message: impl Into<String>) -> AssetError {
    AssetError::Container { message: message.into(), advice: None }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

/// Finds the document and the binary chunk in the bytes of a `.glb` or `.gltf` file.
pub(crate) fn split(bytes: &[u8]) -> Result<Parts, AssetError> {
    if bytes.starts_with(MAGIC) {
        return split_glb(bytes);
    }
    let mut oddities = Vec::new();
    let mut start = 0;
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        start = 3;
        oddities.push("the document starts with a byte order mark, which glTF does not allow".to_owned());
    }
    match bytes[start..].iter().find(|b| !b.is_ascii_whitespace()) {
        None => Err(broken("the file is empty")),
        Some(b'{') => Ok(Parts { json: start..bytes.len(), bin: None, oddities }),
        Some(b'[' | b'n' | b'"') => Err(broken("not a glTF file: the document is not a JSON object")),
        Some(_) => Err(broken("not a glTF file: it starts with neither `glTF` nor `{`")),
    }
}

fn split_glb(bytes: &[u8]) -> Result<Parts, AssetError> {
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(broken("the file ends inside the 12-byte GLB header"));
    };
    if version != 2 {
        return Err(AssetError::Container {
            message: format!("GLB container version {version}; only version 2 is supported"),
            advice: Some("convert the asset to glTF 2.0".to_owned()),
        });
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(broken(format!(
            "the GLB header promises {length} bytes, but the file has {}",
            bytes.len()
        )));
    }
    let mut oddities = Vec::new();
    if length < bytes.len() {
        let more = bytes.len() - length;
        let are = if more == 1 { "is" } else { "are" };
        oddities.push(format!("{} after the end of the GLB {are} ignored", count(more, "byte", "bytes")));
    }
    let bytes = &bytes[..length];
    let mut json = None;
    let mut bin = None;
    let mut at = HEADER;
    let mut chunk = 0;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(broken("the file ends inside a GLB chunk header"));
        };
        let start = at + 8;
        let end = start.checked_add(size as usize).filter(|&end| end <= bytes.len()).ok_or_else(|| {
            broken(format!("GLB chunk {chunk} has {size} bytes, which is beyond the end of the file"))
        })?;
        match (chunk, kind) {
            (0, CHUNK_JSON) => json = Some(start..end),
            (0, _) => return Err(broken("the first GLB chunk is not JSON")),
            (1, CHUNK_BIN) => bin = Some(start..end),
            (_, CHUNK_JSON | CHUNK_BIN) => {
                oddities.push(format!("GLB chunk {chunk} is out of place and is ignored"));
            }
            _ => {}
        }
        chunk += 1;
        at = end.saturating_add(3) & !3;
    }
    match json {
        Some(json) => Ok(Parts { json, bin, oddities }),
        None => Err(broken("the GLB has no JSON chunk")),
    }
}

/// A document, and what is odd about it.
#[derive(Debug)]
pub(crate) struct Parsed {
    /// The document, without properties that are `null`: exporters write them for what they leave out.
    pub document: Value,
    /// Keys that occur twice in one object; the last one counts.
    pub duplicates: Vec<String>,
    /// Keys of some properties that are `null`, and how many there are.
    pub nulls: (Vec<String>, u64),
}

/// Parses a document. A property that is `null` is left out, so that it is absent wherever it is asked for; an entry of an
/// array keeps its place.
pub(crate) fn parse(bytes: &[u8], limit: u64) -> Result<Parsed, AssetError> {
    let mut notes = Notes { left: Some(limit), duplicates: Vec::new(), nulls: (Vec::new(), 0) };
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let result = Tree(&mut notes).deserialize(&mut deserializer).and_then(|v| deserializer.end().map(|()| v));
    if notes.left.is_none() {
        return Err(AssetError::Limit {
            pointer: String::new(),
            what: "the JSON document, in values,".to_owned(),
            needed: limit.saturating_add(1),
            limit,
            field: "json_values",
        });
    }
    let value = result.map_err(|e| {
        let (line, column) = (e.line(), e.column());
        let text = e.to_string();
        let message = text.split(" at line ").next().unwrap_or(&text).to_owned();
        AssetError::Json { message, line, column }
    })?;
    if !value.is_object() {
        return Err(broken("not a glTF file: the document is not a JSON object"));
    }
    Ok(Parsed { document: value, duplicates: notes.duplicates, nulls: notes.nulls })
}

/// What is noted while a document is parsed.
struct Notes {
    /// How many more values are allowed; `None` once there were too many.
    left: Option<u64>,
    /// Keys that occurred twice in one object.
    duplicates: Vec<String>,
    /// Keys of properties that are `null`, each once, and how many there were.
    nulls: (Vec<String>, u64),
}

/// Takes properties that are `null` out of a value.
pub(crate) fn without_nulls(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|_, v| !v.is_null());
            object.values_mut().for_each(without_nulls);
        }
        Value::Array(array) => array.iter_mut().for_each(without_nulls),
        _ => {}
    }
}

/// Builds a [`Value`], counts values, and notes duplicate keys, which `serde_json` alone drops without a word.
struct Tree<'d>(&'d mut Notes);

impl Tree<'_> {
    fn count<E: Error>(&mut self) -> Result<(), E> {
        self.0.left = self.0.left.and_then(|n| n.checked_sub(1));
        if self.0.left.is_none() { Err(E::custom("too many values")) } else { Ok(()) }
    }
}

impl<'de> DeserializeSeed<'de> for Tree<'_> {
    type Value = Value;
    fn deserialize<D: Deserializer<'de>>(mut self, deserializer: D) -> Result<Value, D::Error> {
        self.count()?;
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Tree<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }
    fn visit_bool<E>(self, v: bool) -> Result<Value, E> {
        Ok(Value::Bool(v))
    }
    fn visit_i64<E>(self, v: i64) -> Result<Value, E> {
        Ok(Value::Number(v.into()))
    }
    fn visit_u64<E>(self, v: u64) -> Result<Value, E> {
        Ok(Value::Number(v.into()))
    }
    fn visit_f64<E>(self, v: f64) -> Result<Value, E> {
        Ok(Number::from_f64(v).map_or(Value::Null, Value::Number))
    }
    fn visit_str<E>(self, v: &str) -> Result<Value, E> {
        Ok(Value::String(v.to_owned()))
    }
    fn visit_string<E>(self, v: String) -> Result<Value, E> {
        Ok(Value::String(v))
    }
    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        Value::deserialize(deserializer)
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(item) = seq.next_element_seed(Tree(self.0))? {
            array.push(item);
        }
        Ok(Value::Array(array))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        const REPORTED: usize = 16;
        let mut object = Map::new();
        while let Some(key) = map.next_key::<String>()? {
            let value = map.next_value_seed(Tree(self.0))?;
            if object.contains_key(&key) && self.0.duplicates.len() < REPORTED {
                self.0.duplicates.push(key.clone());
            }
            object.insert(key, value);
        }
        // All at once: taking them out one by one would move what follows each time.
        let (keys, count) = &mut self.0.nulls;
        object.retain(|key, value| {
            if value.is_null() {
                *count += 1;
                if keys.len() < REPORTED && !keys.contains(key) {
                    keys.push(key.clone());
                }
            }
            !value.is_null()
        });
        Ok(Value::Object(object))
    }
}
