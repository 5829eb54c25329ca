//! Accessors (glTF 2.0 §3.6.2): typed, strided, normalised, sparse views of bytes, read into plain vectors.
//!
//! All sizes are checked, with arithmetic that cannot overflow, before anything is allocated.

use super::buffer::Bytes;
use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;

/// Elements of an accessor that has no buffer view, and so no bytes to show for them.
const MOST_ZEROS: u64 = 1 << 22;

/// The number type of an accessor's components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// 5120.
    I8,
    /// 5121.
    U8,
    /// 5122.
    I16,
    /// 5123.
    U16,
    /// 5125.
    U32,
    /// 5126.
    F32,
}

impl Component {
    /// The type of a `componentType`.
    pub fn from_code(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    /// Bytes of one component.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// An accessor whose ranges have been checked.
#[derive(Clone, Debug)]
pub struct Accessor {
    /// JSON pointer.
    pub pointer: String,
    /// Type of the components.
    pub component: Component,
    /// Rows and columns of an element; one column for scalars and vectors.
    pub shape: (usize, usize),
    /// Number of elements.
    pub count: usize,
    /// Integers stand for fractions.
    pub normalized: bool,
    data: Option<Strided>,
    sparse: Option<Sparse>,
}

#[derive(Clone, Debug)]
struct Strided {
    bytes: Bytes,
    stride: usize,
}

#[derive(Clone, Debug)]
struct Sparse {
    indices: Vec<u32>,
    /// Whether the indices increase, as they should.
    sorted: bool,
    values: Strided,
}

/// Rows and columns of an accessor type.
fn shape_of(kind: &str) -> Option<(usize, usize)> {
    Some(match kind {
        "SCALAR" => (1, 1),
        "VEC2" => (2, 1),
        "VEC3" => (3, 1),
        "VEC4" => (4, 1),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

/// Bytes of one element; matrix columns start at multiples of four (§3.6.2.4).
fn element_size(component: Component, (rows, columns): (usize, usize)) -> usize {
    let column = rows * component.size();
    if columns > 1 { column.next_multiple_of(4) * columns } else { column }
}

impl Loader<'_> {
    /// Accessor `index`; `from` is the place that refers to it.
    ///
    /// # Errors
    /// Where there is no such accessor, or its data are not all there.
    pub fn accessor(&mut self, index: usize, from: &str) -> Result<Accessor, AssetError> {
        let json = self.entry("accessors", index, from)?;
        let component = component_of(&json)?;
        let kind = json.str("type")?.ok_or_else(|| json.error_at("type", "is missing"))?;
        let shape = shape_of(kind).ok_or_else(|| json.error_at("type", "is no type of glTF"))?;
        let count = json.usize("count")?.ok_or_else(|| json.error_at("count", "is missing"))?;
        let limit = self.options.limits.vertices.max(self.options.limits.triangles.saturating_mul(3));
        Self::within(
            count as u64,
            limit,
            &json.pointer_to("count"),
            "the accessor, in elements,",
            "vertices",
        )?;
        if count == 0 {
            self.invalid(&json.pointer_to("count"), "0 is below 1")?;
        }
        let size = element_size(component, shape);
        let data = match json.usize("bufferView")? {
            Some(view) => Some(self.strided(&json, view, size, component, count)?),
            None => None,
        };
        let sparse = match json.object("sparse")? {
            Some(sparse) => Some(self.sparse(&sparse, component, size, count)?),
            None => None,
        };
        if data.is_none() {
            let what = "the accessor, which has no buffer view, in elements,";
            Self::within(count as u64, limit.min(MOST_ZEROS), &json.pointer_to("count"), what, "vertices")?;
        }
        if data.is_none() && sparse.is_none() && count > 0 {
            self.warn(json.pointer(), "has no data, so that all its elements are zero", None);
        }
        let normalized = json.bool("normalized")?.unwrap_or(false);
        Ok(Accessor { pointer: json.pointer().to_owned(), component, shape, count, normalized, data, sparse })
    }

    fn strided(
        &mut self,
        json: &Json<'_>,
        view: usize,
        size: usize,
        component: Component,
        count: usize,
    ) -> Result<Strided, AssetError> {
        let from = json.pointer_to("bufferView");
        let bytes = self.buffer_view(view, &from)?;
        let view = self.entry("bufferViews", view, &from)?;
        let mut stride = view.usize("byteStride")?.unwrap_or(size);
        if stride == 0 {
            self.invalid(&view.pointer_to("byteStride"), "0 is below 4; elements are taken to be adjacent")?;
            stride = size;
        } else if stride < size {
            let message =
                format!("{stride} is less than the {size} bytes of an element of {}", json.pointer());
            self.invalid(&view.pointer_to("byteStride"), message)?;
        }
        let offset = json.usize("byteOffset")?.unwrap_or(0);
        if offset % component.size() != 0 || stride % component.size() != 0 {
            self.invalid(json.pointer(), format!("elements are not aligned to {} bytes", component.size()))?;
        }
        let bytes = window(&bytes, offset, stride, size, count).ok_or_else(|| {
            json.error(format!(
                "{count} elements of {size} bytes, {stride} apart, from {offset} on reach beyond the end of its \
                 buffer view, which has {} bytes",
                bytes.len()
            ))
        })?;
        Ok(Strided { bytes, stride })
    }

    fn sparse(
        &mut self,
        json: &Json<'_>,
        component: Component,
        size: usize,
        count: usize,
    ) -> Result<Sparse, AssetError> {
        let missing = |key: &str| json.error_at(key, "is missing");
        let n = json.usize("count")?.ok_or_else(|| missing("count"))?;
        if n > count {
            return Err(json.error_at("count", format!("{n} is more than the {count} of the accessor")));
        }
        let indices = json.object("indices")?.ok_or_else(|| missing("indices"))?;
        let values = json.object("values")?.ok_or_else(|| missing("values"))?;
        let index_type = component_of(&indices)?;
        if !matches!(index_type, Component::U8 | Component::U16 | Component::U32) {
            return Err(indices.error_at("componentType", "sparse indices must be unsigned integers"));
        }
        let view =
            |j: &Json<'_>| j.usize("bufferView")?.ok_or_else(|| j.error_at("bufferView", "is missing"));
        let index_data = self.strided(&indices, view(&indices)?, index_type.size(), index_type, n)?;
        let value_data = self.strided(&values, view(&values)?, size, component, n)?;
        let mut list = Vec::with_capacity(n);
        for i in 0..n {
            let at = i * index_data.stride;
            let index = unsigned(index_type, &index_data.bytes[at..]);
            if index as usize >= count {
                let message = format!("sparse index {index} is beyond the {count} elements of the accessor");
                return Err(indices.error(message));
            }
            list.push(index);
        }
        let sorted = list.windows(2).all(|w| w[0] < w[1]);
        if !sorted {
            self.invalid(indices.pointer(), "sparse indices do not increase")?;
        }
        Ok(Sparse { indices: list, sorted, values: value_data })
    }
}

fn component_of(json: &Json<'_>) -> Result<Component, AssetError> {
    let code = json.usize("componentType")?.ok_or_else(|| json.error_at("componentType", "is missing"))?;
    Component::from_code(code)
        .ok_or_else(|| json.error_at("componentType", format!("{code} is no component type of glTF")))
}

/// The bytes that `count` elements span.
fn window(bytes: &Bytes, offset: usize, stride: usize, size: usize, count: usize) -> Option<Bytes> {
    let Some(last) = count.checked_sub(1) else { return bytes.slice(0, 0) };
    let span = last.checked_mul(stride)?.checked_add(size)?;
    bytes.slice(offset, span)
}

fn unsigned(component: Component, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (Component::U8 | Component::I8, [a, ..]) => u32::from(*a),
        (Component::U16 | Component::I16, [a, b, ..]) => u32::from(u16::from_le_bytes([*a, *b])),
        (_, [a, b, c, d, ..]) => u32::from_le_bytes([*a, *b, *c, *d]),
        _ => 0,
    }
}

/// One component as a number, normalised as §3.6.2.2 has it.
fn number(component: Component, normalized: bool, bytes: &[u8]) -> f32 {
    let raw = unsigned(component, bytes);
    let scaled = |value: f32, top: f32| if normalized { (value / top).max(-1.0) } else { value };
    match component {
        Component::F32 => f32::from_bits(raw),
        Component::I8 => scaled(f32::from(raw as u8 as i8), 127.0),
        Component::U8 => scaled(raw as f32, 255.0),
        Component::I16 => scaled(f32::from(raw as u16 as i16), 32767.0),
        Component::U16 => scaled(raw as f32, 65535.0),
        Component::U32 => scaled(raw as f32, u32::MAX as f32),
    }
}

impl Accessor {
    /// The same accessor without its sparse part.
    pub fn without_sparse(&self) -> Self {
        Self { sparse: None, ..self.clone() }
    }

    /// Whether an element is a vector (or scalar) of `components` components.
    pub fn is_vector(&self, components: usize) -> bool {
        self.shape == (components, 1)
    }

    /// Element `index` as `N` numbers, as [`floats`](Self::floats) has it; zeros where there is none. Meant for a few
    /// elements of many: the others are not touched.
    pub fn element<const N: usize>(&self, index: usize) -> [f32; N] {
        let sparse = self.sparse.as_ref().and_then(|sparse| {
            let wanted = u32::try_from(index).ok()?;
            let place = if sparse.sorted {
                sparse.indices.binary_search(&wanted).ok()?
            } else {
                sparse.indices.iter().rposition(|&i| i == wanted)?
            };
            sparse.values.bytes.get(place * sparse.values.stride..)
        });
        let plain = || self.data.as_ref()?.bytes.get(index.checked_mul(self.data.as_ref()?.stride)?..);
        if index >= self.count { [0.0; N] } else { self.read(sparse.or_else(plain).unwrap_or_default()) }
    }

    /// The element that begins with these bytes; zeros without bytes.
    fn read<const N: usize>(&self, bytes: &[u8]) -> [f32; N] {
        let (rows, columns) = self.shape;
        let size = self.component.size();
        let column_size = element_size(self.component, self.shape) / columns;
        let mut element = [0.0; N];
        for (k, slot) in element.iter_mut().enumerate().take(rows * columns) {
            let at = (k / rows) * column_size + (k % rows) * size;
            *slot = number(self.component, self.normalized, bytes.get(at..).unwrap_or_default());
        }
        element
    }

    /// The elements as vectors of `N` numbers; missing components are zero, additional ones are left out.
    pub fn floats<const N: usize>(&self) -> Vec<[f32; N]> {
        let read = |bytes: &[u8]| self.read::<N>(bytes);
        let mut elements = match &self.data {
            Some(data) => {
                (0..self.count).map(|i| read(data.bytes.get(i * data.stride..).unwrap_or_default())).collect()
            }
            None => vec![[0.0; N]; self.count],
        };
        if let Some(sparse) = &self.sparse {
            for (i, &index) in sparse.indices.iter().enumerate() {
                let bytes = sparse.values.bytes.get(i * sparse.values.stride..).unwrap_or_default();
                if let Some(slot) = elements.get_mut(index as usize) {
                    *slot = read(bytes);
                }
            }
        }
        elements
    }

    /// The elements of an unsigned scalar accessor.
    ///
    /// # Errors
    /// Where it is not one.
    pub fn indices(&self) -> Result<Vec<u32>, AssetError> {
        let unsigned_type = matches!(self.component, Component::U8 | Component::U16 | Component::U32);
        if !unsigned_type || self.shape != (1, 1) {
            return Err(AssetError::invalid(&self.pointer, "indices must be unsigned scalars"));
        }
        let mut elements: Vec<u32> = match &self.data {
            Some(data) => (0..self.count)
                .map(|i| unsigned(self.component, data.bytes.get(i * data.stride..).unwrap_or_default()))
                .collect(),
            None => vec![0; self.count],
        };
        if let Some(sparse) = &self.sparse {
            for (i, &index) in sparse.indices.iter().enumerate() {
                let bytes = sparse.values.bytes.get(i * sparse.values.stride..).unwrap_or_default();
                if let Some(slot) = elements.get_mut(index as usize) {
                    *slot = unsigned(self.component, bytes);
                }
            }
        }
        Ok(elements)
    }
}
