//! How new values look among their neighbours: on one line or on several, with the indentation that is there.

use super::{Entry, List, Node};
use serde_json::Value;
use std::borrow::Cow;

/// How new text looks among its neighbours.
pub(super) struct Layout {
    pub colon: String,
    /// Indentation of the lines of members; `None` where all is on one line.
    indent: Option<String>,
    step: String,
}

impl Layout {
    /// The layout of what is in a list.
    pub fn of(list: &List<'_>) -> Self {
        let colon = list.entries.last().map(|e| e.colon.to_string()).filter(|colon| !colon.is_empty());
        let before = list.entries.last().map_or("", |e| &*e.before);
        let indent = before.rsplit_once('\n').map(|(_, indent)| indent.to_owned());
        let step = match &indent {
            Some(indent) if indent.starts_with('\t') => "\t".to_owned(),
            // The step cannot be told from one line; files use two or four blanks.
            Some(indent) if indent.len() % 4 != 0 => "  ".to_owned(),
            _ => "    ".to_owned(),
        };
        Self { colon: colon.unwrap_or_else(|| ": ".to_owned()), indent, step }
    }

    pub fn write(&self, value: &Value) -> Node<'static> {
        let entry = |key: String, colon: &str, value, before: String| Entry {
            before: Cow::Owned(before),
            key: Cow::Owned(key),
            colon: Cow::Owned(colon.to_owned()),
            value,
            after: Cow::Borrowed(""),
        };
        let wide = self.colon.ends_with(' ') || self.indent.is_some();
        let blank = |i: usize| if i > 0 && wide { " " } else { "" }.to_owned();
        match value {
            Value::Array(items) => {
                let entries = items.iter().enumerate();
                let entries =
                    entries.map(|(i, v)| entry(String::new(), "", self.inner().write(v), blank(i))).collect();
                Node::Array(List { entries, space: Cow::Borrowed("") })
            }
            Value::Object(members) => {
                let inner = self.inner();
                let before = |i: usize| match &inner.indent {
                    Some(indent) => format!("\n{indent}"),
                    None => blank(i),
                };
                let members = members.iter().enumerate();
                let mut entries: Vec<_> = members
                    .map(|(i, (k, v))| {
                        entry(Value::from(&**k).to_string(), &self.colon, inner.write(v), before(i))
                    })
                    .collect();
                if let (Some(last), Some(indent)) = (entries.last_mut(), &self.indent) {
                    last.after = Cow::Owned(format!("\n{indent}"));
                }
                Node::Object(List { entries, space: Cow::Borrowed("") })
            }
            Value::Number(number) => Node::Scalar(Cow::Owned(number_text(number))),
            other => Node::Scalar(Cow::Owned(other.to_string())),
        }
    }

    /// The layout one level further in.
    fn inner(&self) -> Self {
        let indent = self.indent.as_ref().map(|indent| format!("{indent}{}", self.step));
        Self { colon: self.colon.clone(), indent, step: self.step.clone() }
    }
}

/// The shortest spelling that reads as the same double; whole numbers without a fraction.
fn number_text(number: &serde_json::Number) -> String {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match number.as_f64() {
        Some(x) if x.fract() == 0.0 && x.abs() < EXACT => format!("{}", x as i64),
        _ => number.to_string(),
    }
}
