//! A place in a JSON document: a value together with its pointer, so that every complaint can say where.
//!
//! Nothing in a glTF document can be trusted to have the type its specification says, so all access goes through
//! these checked readers. An absent property is `None`; one of the wrong type is an error. Numbers come out as `f64`.

use serde_json::{Map, Value};

use super::error::{AssetError, count as plural, shorten};

/// A JSON value and the pointer (RFC 6901) that leads to it.
#[derive(Clone, Debug)]
pub struct Json<'a> {
    value: &'a Value,
    pointer: String,
}

impl<'a> Json<'a> {
    /// The root of a document.
    pub fn root(value: &'a Value) -> Self {
        Self { value, pointer: String::new() }
    }

    /// The value itself.
    pub fn value(&self) -> &'a Value {
        self.value
    }

    /// JSON pointer of this value.
    pub fn pointer(&self) -> &str {
        &self.pointer
    }

    /// JSON pointer of a property of this value, present or not.
    pub fn pointer_to(&self, key: &str) -> String {
        if key.contains(['~', '/']) {
            return format!("{}/{}", self.pointer, key.replace('~', "~0").replace('/', "~1"));
        }
        format!("{}/{key}", self.pointer)
    }

    /// An error about this value.
    pub fn error(&self, message: impl Into<String>) -> AssetError {
        AssetError::invalid(self.pointer.clone(), message)
    }

    /// An error about a property of this value.
    pub fn error_at(&self, key: &str, message: impl Into<String>) -> AssetError {
        AssetError::invalid(self.pointer_to(key), message)
    }

    fn wrong_type(&self, expected: &str) -> AssetError {
        let found = match self.value {
            Value::Null => "null".to_owned(),
            Value::Bool(b) => b.to_string(),
            Value::Number(n) => n.to_string(),
            Value::String(s) => format!("\"{}\"", shorten(s)),
            Value::Array(_) => "an array".to_owned(),
            Value::Object(_) => "an object".to_owned(),
        };
        self.error(format!("{found} where {expected} is expected"))
    }

    /// A property, if present.
    pub fn get(&self, key: &str) -> Option<Json<'a>> {
        let value = self.value.as_object()?.get(key)?;
        Some(Json { value, pointer: self.pointer_to(key) })
    }

    /// This value as an object.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn as_object(&self) -> Result<&'a Map<String, Value>, AssetError> {
        self.value.as_object().ok_or_else(|| self.wrong_type("an object"))
    }

    /// This value as a string.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn as_str(&self) -> Result<&'a str, AssetError> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a string"))
    }

    /// This value as a number, always finite.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn as_f64(&self) -> Result<f64, AssetError> {
        self.value.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.wrong_type("a number"))
    }

    /// This value as a non-negative integer. Numbers such as `3.0` count as integers.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn as_usize(&self) -> Result<usize, AssetError> {
        const EXACT: f64 = 9_007_199_254_740_992.0;
        let whole = |x: f64| ((0.0..=EXACT).contains(&x) && x.fract() == 0.0).then_some(x as u64);
        (self.value.as_u64())
            .or_else(|| self.value.as_f64().and_then(whole))
            .and_then(|n| usize::try_from(n).ok())
            .ok_or_else(|| self.wrong_type("a non-negative integer"))
    }

    /// The entries of this array.
    ///
    /// # Errors
    /// Where it is not an array.
    pub fn items(&self) -> Result<impl Iterator<Item = Json<'a>> + use<'a>, AssetError> {
        let array = self.value.as_array().ok_or_else(|| self.wrong_type("an array"))?;
        let pointer = self.pointer.clone();
        let item = move |(i, value)| Json { value, pointer: format!("{pointer}/{i}") };
        Ok(array.iter().enumerate().map(item))
    }

    /// Entry `index` of this array, if present.
    pub fn item(&self, index: usize) -> Option<Json<'a>> {
        let value = self.value.as_array()?.get(index)?;
        Some(Json { value, pointer: format!("{}/{index}", self.pointer) })
    }

    /// Property `key` as an object.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn object(&self, key: &str) -> Result<Option<Json<'a>>, AssetError> {
        self.get(key).map(|v| v.as_object().map(|_| v)).transpose()
    }

    /// The entries of array `key`; none where it is absent.
    ///
    /// # Errors
    /// Where it is not an array.
    pub fn array(&self, key: &str) -> Result<Vec<Json<'a>>, AssetError> {
        match self.get(key) {
            Some(array) => Ok(array.items()?.collect()),
            None => Ok(Vec::new()),
        }
    }

    /// Property `key` as a string.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn str(&self, key: &str) -> Result<Option<&'a str>, AssetError> {
        self.get(key).map(|v| v.as_str()).transpose()
    }

    /// Property `key` as a finite number.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn f64(&self, key: &str) -> Result<Option<f64>, AssetError> {
        self.get(key).map(|v| v.as_f64()).transpose()
    }

    /// Property `key` as a boolean.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn bool(&self, key: &str) -> Result<Option<bool>, AssetError> {
        let read = |v: Json<'_>| v.value.as_bool().ok_or_else(|| v.wrong_type("true or false"));
        self.get(key).map(read).transpose()
    }

    /// Property `key` as a non-negative integer.
    ///
    /// # Errors
    /// Where it is something else.
    pub fn usize(&self, key: &str) -> Result<Option<usize>, AssetError> {
        self.get(key).map(|v| v.as_usize()).transpose()
    }

    /// Property `key` as `N` finite numbers.
    ///
    /// # Errors
    /// Where it is anything else.
    pub fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, AssetError> {
        let Some(array) = self.get(key) else { return Ok(None) };
        let mut numbers = [0.0; N];
        let mut count = 0;
        for item in array.items()? {
            let number = item.as_f64()?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = number;
            }
            count += 1;
        }
        if count != N {
            return Err(array.error(format!("{} where {N} are expected", plural(count, "number", "numbers"))));
        }
        Ok(Some(numbers))
    }

    /// The extension object `name` of this object, if present.
    pub fn extension(&self, name: &str) -> Option<Json<'a>> {
        // Most are absent, which is known before any pointer is made.
        self.value.get("extensions")?.get(name)?;
        self.get("extensions")?.get(name)
    }

    /// The name of this object, or `fallback`.
    pub fn name_or(&self, fallback: impl FnOnce() -> String) -> String {
        match self.value.get("name").and_then(Value::as_str) {
            Some(name) if !name.is_empty() => name.to_owned(),
            _ => fallback(),
        }
    }
}
