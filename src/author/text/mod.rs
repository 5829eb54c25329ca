//! JSON text as a tree that prints itself back to the byte.
//!
//! An editor of somebody else's file must not touch what it was not asked to: how numbers are spelt (`1.0`, `1e-7`), the
//! order of keys, white space, properties that nobody knows. So the text is kept as slices of the source, and only what
//! is set or removed changes. Grammar: RFC 8259.

mod layout;
mod parse;

use crate::asset::container::without_nulls;
use layout::Layout;
use parse::Parser;
use serde_json::Value;
use std::borrow::Cow;

/// A document: its root value and the white space around it.
#[derive(Clone, Debug)]
pub struct Tree<'a> {
    before: &'a str,
    root: Node<'a>,
    after: &'a str,
}

/// A value.
#[derive(Clone, Debug)]
pub enum Node<'a> {
    /// A number, a string, `true`, `false` or `null`, as spelt.
    Scalar(Cow<'a, str>),
    /// An array.
    Array(List<'a>),
    /// An object.
    Object(List<'a>),
}

/// What is between two brackets.
#[derive(Clone, Debug, Default)]
pub struct List<'a> {
    entries: Vec<Entry<'a>>,
    /// White space where there are no entries.
    space: Cow<'a, str>,
}

/// A value of an array, or a member of an object.
#[derive(Clone, Debug)]
struct Entry<'a> {
    before: Cow<'a, str>,
    /// The key in its quotes, and the colon with the white space around it; empty in arrays.
    key: Cow<'a, str>,
    colon: Cow<'a, str>,
    value: Node<'a>,
    after: Cow<'a, str>,
}

/// The text is not JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not JSON at byte {at}")]
pub struct NotJson {
    /// Where, in bytes from the start.
    pub at: usize,
}

impl<'a> Tree<'a> {
    /// Takes a document apart.
    ///
    /// # Errors
    /// Where the text is not JSON, or nests more than 128 deep.
    pub fn parse(text: &'a str) -> Result<Self, NotJson> {
        let mut parser = Parser { text, at: 0 };
        let before = parser.space();
        let root = parser.value(0)?;
        let after = parser.space();
        if parser.at < text.len() {
            return Err(NotJson { at: parser.at });
        }
        Ok(Self { before, root, after })
    }

    /// The root value.
    pub fn root(&self) -> &Node<'a> {
        &self.root
    }

    /// The root value, to be changed.
    pub fn root_mut(&mut self) -> &mut Node<'a> {
        &mut self.root
    }
}

impl std::fmt::Display for Tree<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}{}", self.before, self.root, self.after)
    }
}

impl std::fmt::Display for Node<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (list, open, close) = match self {
            Self::Scalar(text) => return f.write_str(text),
            Self::Array(list) => (list, '[', ']'),
            Self::Object(list) => (list, '{', '}'),
        };
        write!(f, "{open}")?;
        for (i, entry) in list.entries.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let Entry { before, key, colon, value, after } = entry;
            write!(f, "{comma}{before}{key}{colon}{value}{after}")?;
        }
        if list.entries.is_empty() {
            f.write_str(&list.space)?;
        }
        write!(f, "{close}")
    }
}

impl<'a> Node<'a> {
    /// The value as data, without members that are `null`, as the loader reads it; `None` for a number that a double cannot
    /// hold.
    pub fn value(&self) -> Option<Value> {
        let mut value = serde_json::from_str(&self.to_string()).ok()?;
        without_nulls(&mut value);
        Some(value)
    }

    /// The member of that key; of several the last, which is the one that counts. One that is `null` counts as absent.
    pub fn get(&self, key: &str) -> Option<&Node<'a>> {
        let Self::Object(list) = self else { return None };
        list.entries.iter().rev().find(|e| e.is(key)).map(|e| &e.value).filter(|value| !value.is_null())
    }

    /// [`Node::get`], to be changed.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Node<'a>> {
        let Self::Object(list) = self else { return None };
        let found = list.entries.iter_mut().rev().find(|e| e.is(key));
        found.map(|e| &mut e.value).filter(|value| !value.is_null())
    }

    fn is_null(&self) -> bool {
        matches!(self, Self::Scalar(text) if text == "null")
    }

    /// Entry `index` of an array, to be changed.
    pub fn item_mut(&mut self, index: usize) -> Option<&mut Node<'a>> {
        match self {
            Self::Array(list) => list.entries.get_mut(index).map(|e| &mut e.value),
            _ => None,
        }
    }

    /// Number of members or entries; 0 for scalars.
    pub fn len(&self) -> usize {
        match self {
            Self::Scalar(_) => 0,
            Self::Array(list) | Self::Object(list) => list.entries.len(),
        }
    }

    /// Whether there are no members or entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The member of that key, to be changed; an empty object is put there if there is none. `None` where this is no
    /// object.
    pub fn object_mut(&mut self, key: &str) -> Option<&mut Node<'a>> {
        if self.get(key).is_none() {
            self.set(key, &Value::Object(serde_json::Map::new()));
        }
        self.get_mut(key)
    }

    /// Gives a member a value. One that means the same already keeps its spelling; a new one comes last and is laid out
    /// as its neighbours are. Does nothing where this is no object.
    pub fn set(&mut self, key: &str, value: &Value) {
        let Self::Object(list) = self else { return };
        let layout = Layout::of(list);
        if let Some(entry) = list.entries.iter_mut().rev().find(|e| e.is(key)) {
            if !entry.value.value().is_some_and(|old| same(&old, value)) {
                entry.value = layout.write(value);
            }
            return;
        }
        let colon = Cow::Owned(layout.colon.clone());
        list.push(Cow::Owned(Value::from(key).to_string()), colon, layout.write(value));
    }

    /// Adds an entry to the end of an array. Does nothing where this is no array.
    pub fn push(&mut self, value: &Value) {
        let Self::Array(list) = self else { return };
        let node = Layout::of(list).write(value);
        list.push(Cow::Borrowed(""), Cow::Borrowed(""), node);
    }

    /// Removes the members of that key; whether there were any.
    pub fn remove(&mut self, key: &str) -> bool {
        match self {
            Self::Object(list) => list.remove(|entry| entry.is(key)),
            _ => false,
        }
    }

    /// Removes the entries of an array that are this string; whether there were any.
    pub fn remove_string(&mut self, text: &str) -> bool {
        match self {
            Self::Array(list) => list.remove(|entry| entry.value.is_string(text)),
            _ => false,
        }
    }

    /// Whether this is that string.
    pub fn is_string(&self, text: &str) -> bool {
        matches!(self, Self::Scalar(raw) if is_quoted(raw, text))
    }

    /// Whether an array holds that string.
    pub fn has_string(&self, text: &str) -> bool {
        matches!(self, Self::Array(list) if list.entries.iter().any(|e| e.value.is_string(text)))
    }
}

impl<'a> List<'a> {
    fn push(&mut self, key: Cow<'a, str>, colon: Cow<'a, str>, value: Node<'a>) {
        let count = self.entries.len();
        let between = if count > 1 { self.entries[0].after.clone() } else { Cow::Borrowed("") };
        let (before, after) = match self.entries.last_mut() {
            Some(last) => (last.before.clone(), std::mem::replace(&mut last.after, between)),
            None => (Cow::Borrowed(""), Cow::Borrowed("")),
        };
        self.entries.push(Entry { before, key, colon, value, after });
    }

    fn remove(&mut self, unwanted: impl Fn(&Entry<'a>) -> bool) -> bool {
        let (first, last) = match &self.entries[..] {
            [first, .., last] => (first.before.clone(), last.after.clone()),
            [only] => (only.before.clone(), only.after.clone()),
            [] => return false,
        };
        let before = self.entries.len();
        self.entries.retain(|entry| !unwanted(entry));
        if self.entries.len() == before {
            return false;
        }
        if let Some(entry) = self.entries.first_mut() {
            entry.before = first;
        }
        if let Some(entry) = self.entries.last_mut() {
            entry.after = last;
        }
        true
    }
}

impl Entry<'_> {
    fn is(&self, key: &str) -> bool {
        is_quoted(&self.key, key)
    }
}

fn is_quoted(raw: &str, text: &str) -> bool {
    if raw.contains('\\') {
        return serde_json::from_str::<String>(raw).is_ok_and(|decoded| decoded == text);
    }
    raw.strip_prefix('"').and_then(|raw| raw.strip_suffix('"')) == Some(text)
}

/// Whether two values mean the same; numbers by their value, so that 1 is 1.0.
pub fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a == b || a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        (a, b) => a == b,
    }
}

#[cfg(test)]
mod tests;
