//! Mutations that keep a file a file: what plain ones hardly ever do, since a flipped bit breaks JSON or a length.
//!
//! A document is changed at a few places drawn at random: a value becomes an odd one, a number its neighbor, a member goes
//! away or turns up elsewhere, an extension is added. Buffers get odd numbers at aligned places. In one of some dozen
//! changes the container lies about its lengths.

use serde_json::{Value, json};

use super::dictionary;

/// A small generator (splitmix64).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`; 0 where `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n.max(1) as u64) as usize
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A `.glb` or `.gltf` file, changed; `None` where it is not one.
pub fn loader(file: &[u8], seed: u64) -> Option<Vec<u8>> {
    let mut random = Random(seed);
    let Some((json, mut bin)) = parts(file) else {
        let mut document: Value = serde_json::from_slice(file).ok()?;
        some_changes(&mut document, &mut random);
        return Some(document.to_string().into_bytes());
    };
    let mut document: Value = serde_json::from_slice(json).ok()?;
    if bin.is_empty() || random.below(3) > 0 {
        some_changes(&mut document, &mut random);
    } else {
        numbers(&mut bin, &mut random);
    }
    let mut file = glb(document.to_string().into_bytes(), &bin);
    if random.once_in(16) {
        // A length or a type of the header or of a chunk.
        let second = HEADER + CHUNK_HEADER + json.len();
        let at = [0, 4, 8, 12, 16, second, second + 4][random.below(7)];
        if let Some(word) = file.get_mut(at..at + 4) {
            word.copy_from_slice(&odd_word(&mut random).to_le_bytes());
        }
    }
    Some(file)
}

/// The JSON of a material, changed; `None` where it is not JSON.
pub fn extensions(text: &[u8], seed: u64) -> Option<Vec<u8>> {
    let mut random = Random(seed);
    let mut material: Value = serde_json::from_slice(text).ok()?;
    some_changes(&mut material, &mut random);
    Some(material.to_string().into_bytes())
}

/// A payload with an odd number somewhere; `None` where it is too short for one.
pub fn payloads(data: &[u8], seed: u64) -> Option<Vec<u8>> {
    let mut data = data.to_vec();
    let (kind, rest) = data.split_first_mut()?;
    let mut rest = rest.to_vec();
    if rest.len() < 8 {
        return None;
    }
    let kind = *kind;
    let mut random = Random(seed);
    numbers(&mut rest, &mut random);
    if random.once_in(4) {
        let from = random.below(rest.len());
        let count = 1 + random.below(16.min(rest.len() - from));
        let piece = rest[from..from + count].to_vec();
        let to = random.below(rest.len());
        rest.splice(to..to, piece);
    }
    rest.insert(0, kind);
    Some(rest)
}

/// Lines of Radiance headers, and sizes.
const LINES: [&str; 14] = [
    "FORMAT=32-bit_rle_rgbe",
    "FORMAT=32-bit_rle_xyze",
    "EXPOSURE=1e-30",
    "EXPOSURE=1e300",
    "EXPOSURE=0.5",
    "COLORCORR=1 2 4",
    "PRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329",
    "PRIMARIES=0 1 0 1e-30 1 0 1 1",
    "",
    "-Y 8 +X 16",
    "+X 16 +Y 8",
    "-X 8 -Y 1",
    "+Y 1 +X 128",
    "-Y 65536 +X 65536",
];

/// A picture with a line of its header changed, or with odd numbers at any place, as those of headers are not aligned;
/// `None` where it is too short.
pub fn environments(file: &[u8], seed: u64) -> Option<Vec<u8>> {
    let mut random = Random(seed);
    let mut file = file.to_vec();
    if file.len() < 16 {
        return None;
    }
    let ends: Vec<usize> = (0..file.len()).filter(|&at| file[at] == b'\n').take(6).collect();
    if file.starts_with(b"#?") && !ends.is_empty() && random.once_in(2) {
        let start = ends[random.below(ends.len())] + 1;
        let end = ends.iter().copied().find(|&end| end >= start).unwrap_or(start);
        let replace = if random.once_in(2) { start..end.min(file.len()) } else { start..start };
        let line =
            [LINES[random.below(LINES.len())].as_bytes(), if replace.is_empty() { b"\n" } else { b"" }]
                .concat();
        file.splice(replace, line);
        return Some(file);
    }
    // Headers of OpenEXR have some hundred bytes, and so have the first blocks.
    let from = if random.once_in(2) { 0 } else { random.below(file.len() - 8) };
    for _ in 0..=random.below(3) {
        let width = [8, 4, 2, 1][random.below(4)];
        let at = from + random.below((file.len() - from).min(640) - width + 1);
        let word = u64::from(if random.once_in(3) { random.bits() as u32 } else { odd_word(&mut random) });
        let word = if random.once_in(2) { word } else { word << 16 };
        if let Some(place) = file.get_mut(at..at + width) {
            place.copy_from_slice(&word.to_le_bytes()[..width]);
        }
    }
    Some(file)
}

/// The document and the binary chunk of a GLB whose lengths are sound.
fn parts(file: &[u8]) -> Option<(&[u8], Vec<u8>)> {
    if !file.starts_with(b"glTF") {
        return None;
    }
    let chunk = |at: usize| {
        let size = u32::from_le_bytes(file.get(at..at + 4)?.try_into().ok()?) as usize;
        let start = at + CHUNK_HEADER;
        file.get(start..start.checked_add(size)?)
    };
    let json = chunk(HEADER)?;
    let bin = chunk(HEADER + CHUNK_HEADER + json.len()).unwrap_or_default();
    Some((json, bin.to_vec()))
}

/// A GLB with these chunks.
pub fn glb(mut json: Vec<u8>, bin: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(&json);
    if !bin.is_empty() {
        file.extend((bin.len().next_multiple_of(4) as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(bin);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}

fn odd_word(random: &mut Random) -> u32 {
    const WORDS: [u32; 16] = [
        0,
        1,
        2,
        3,
        u32::MAX,
        i32::MAX as u32,
        0x8000_0000,
        0xFFFF,
        0x7FC0_0000, // NaN
        0x7F80_0000, // infinity
        0xFF80_0000, // −infinity
        0x7F7F_FFFF, // the largest float
        0x0000_0001, // the smallest, denormal
        0x3F80_0000, // 1
        0x7149_F2CA, // 1e30
        0x0DA2_4260, // 1e-30
    ];
    WORDS[random.below(WORDS.len())]
}

/// One to three words, shorts or bytes become odd ones.
fn numbers(data: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(3) {
        let width = [4, 4, 2, 1][random.below(4)];
        let at = random.below(data.len() / width) * width;
        if let Some(place) = data.get_mut(at..at + width) {
            let word = if random.once_in(3) { random.bits() as u32 } else { odd_word(random) };
            place.copy_from_slice(&word.to_le_bytes()[..width]);
        }
    }
}

/// One to four changes of a document.
pub fn some_changes(document: &mut Value, random: &mut Random) {
    for _ in 0..=random.below(4) {
        change(document, random);
    }
}

fn change(document: &mut Value, random: &mut Random) {
    let pointers = pointers(document);
    let any = |random: &mut Random| pointers[random.below(pointers.len())].clone();
    let (here, there) = (any(random), any(random));
    let other = document.pointer(&there).cloned().unwrap_or_default();
    let Some(value) = document.pointer_mut(&here) else { return };
    match random.below(8) {
        0 => *value = odd(random),
        1 | 2 => tweak(value, random),
        3 => *value = other,
        4 => remove(document, &here, random),
        5 => match value {
            Value::Array(items) => items.push(other),
            Value::Object(members) => {
                let key = there.rsplit('/').next().unwrap_or_default();
                members.insert(key.to_owned(), other);
            }
            _ => tweak(value, random),
        },
        6 => dictionary::add_extension(document, random),
        _ => {
            if let Value::Object(members) = value {
                let (key, value) = dictionary::property(random);
                members.insert(key, value);
            } else {
                tweak(value, random);
            }
        }
    }
}

/// Pointers to all values.
fn pointers(document: &Value) -> Vec<String> {
    let mut all = Vec::new();
    let mut stack = vec![(String::new(), document)];
    while let Some((here, value)) = stack.pop() {
        let child = |key: &str| format!("{here}/{}", key.replace('~', "~0").replace('/', "~1"));
        match value {
            Value::Object(o) => stack.extend(o.iter().map(|(k, v)| (child(k), v))),
            Value::Array(a) => stack.extend(a.iter().enumerate().map(|(i, v)| (child(&i.to_string()), v))),
            _ => {}
        }
        all.push(here);
    }
    all
}

fn remove(document: &mut Value, here: &str, random: &mut Random) {
    let Some((parent, key)) = here.rsplit_once('/') else { return };
    match document.pointer_mut(parent) {
        Some(Value::Object(members)) => drop(members.shift_remove(key)),
        Some(Value::Array(items)) if !items.is_empty() => drop(items.remove(random.below(items.len()))),
        _ => {}
    }
}

/// A number near the one that is there, or a string from the dictionary.
fn tweak(value: &mut Value, random: &mut Random) {
    match value {
        Value::Number(number) => {
            let x = number.as_f64().unwrap_or(0.0);
            let whole = number.is_i64() || number.is_u64();
            let new = [x + 1.0, x - 1.0, -x, 2.0 * x, 0.5 * x, x * 1e10, x * 1e-10, x + 0.1, x * 256.0]
                [random.below(9)];
            // Beyond 2^53 a double holds integers that nobody wrote.
            *value =
                if whole && new.fract() == 0.0 && new.abs() < 9e15 { json!(new as i64) } else { json!(new) };
        }
        Value::String(text) => *text = dictionary::string(random),
        Value::Bool(b) => *b = !*b,
        Value::Array(items) if !items.is_empty() => {
            let (i, j) = (random.below(items.len()), random.below(items.len()));
            items.swap(i, j);
        }
        other => *other = odd(random),
    }
}

/// A value that is seldom right.
pub fn odd(random: &mut Random) -> Value {
    match random.below(18) {
        0 => Value::Null,
        1 => json!(true),
        2 => json!(-1),
        3 => json!(0),
        4 => json!(1),
        5 => json!(2.5),
        6 => json!(1e300),
        7 => json!(-1e300),
        8 => json!(1e-300),
        9 => json!(u64::MAX),
        10 => json!(4_294_967_295_u64),
        11 => json!(f64::from(f32::MAX)),
        12 => json!(dictionary::string(random)),
        13 => json!([]),
        14 => json!([1e39, -1e39, 0, 1]),
        15 => json!({}),
        16 => json!(random.below(10)),
        _ => json!(random.bits() as f64 / u64::MAX as f64),
    }
}
