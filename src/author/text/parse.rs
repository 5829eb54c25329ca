//! From text to a tree of its slices, by recursive descent; the depth is limited.

use super::{Entry, List, Node, NotJson};
use std::borrow::Cow;

/// Deeper nesting is refused, as `serde_json` does.
const DEEPEST: usize = 128;

pub(super) struct Parser<'a> {
    pub text: &'a str,
    pub at: usize,
}

impl<'a> Parser<'a> {
    fn byte(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn error(&self) -> NotJson {
        NotJson { at: self.at }
    }

    fn since(&self, start: usize) -> &'a str {
        self.text.get(start..self.at).unwrap_or_default()
    }

    pub fn space(&mut self) -> &'a str {
        let start = self.at;
        while matches!(self.byte(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
        self.since(start)
    }

    pub fn value(&mut self, depth: usize) -> Result<Node<'a>, NotJson> {
        if depth > DEEPEST {
            return Err(self.error());
        }
        match self.byte() {
            Some(b'{') => Ok(Node::Object(self.list(b'}', depth)?)),
            Some(b'[') => Ok(Node::Array(self.list(b']', depth)?)),
            Some(b'"') => Ok(Node::Scalar(Cow::Borrowed(self.string()?))),
            _ => {
                let start = self.at;
                while self.byte().is_some_and(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b)) {
                    self.at += 1;
                }
                let text = self.since(start);
                if serde_json::from_str::<serde::de::IgnoredAny>(text).is_err() {
                    return Err(NotJson { at: start });
                }
                Ok(Node::Scalar(Cow::Borrowed(text)))
            }
        }
    }

    fn list(&mut self, close: u8, depth: usize) -> Result<List<'a>, NotJson> {
        self.at += 1;
        let mut entries = Vec::new();
        let mut before = self.space();
        if self.byte() == Some(close) {
            self.at += 1;
            return Ok(List { entries, space: Cow::Borrowed(before) });
        }
        loop {
            let (mut key, mut colon) = ("", "");
            if close == b'}' {
                key = self.string()?;
                let start = self.at;
                self.space();
                if self.byte() != Some(b':') {
                    return Err(self.error());
                }
                self.at += 1;
                self.space();
                colon = self.since(start);
            }
            let value = self.value(depth + 1)?;
            let after = self.space();
            let [before_, key, colon, after] = [before, key, colon, after].map(Cow::Borrowed);
            entries.push(Entry { before: before_, key, colon, value, after });
            let next = self.byte();
            self.at += 1;
            match next {
                Some(b',') => before = self.space(),
                Some(b) if b == close => return Ok(List { entries, space: Cow::Borrowed("") }),
                _ => return Err(NotJson { at: self.at - 1 }),
            }
        }
    }

    /// A string with its quotes. What is in it is left to `serde_json`.
    fn string(&mut self) -> Result<&'a str, NotJson> {
        let start = self.at;
        if self.byte() != Some(b'"') {
            return Err(self.error());
        }
        self.at += 1;
        loop {
            match self.byte() {
                Some(b'"') => break,
                Some(b'\\') => self.at += 2,
                Some(_) => self.at += 1,
                None => return Err(self.error()),
            }
        }
        self.at += 1;
        Ok(self.since(start))
    }
}
