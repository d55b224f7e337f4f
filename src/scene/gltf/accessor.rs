//! Checked reading of glTF accessors: every component type, normalised or not, strided, sparse, or without a
//! buffer view at all (zeros).
//!
//! All arithmetic on offsets is checked `u64`; values come out as `f64`, which holds every component exactly.
//! Source of the decoding rules: glTF 2.0, 3.6.2 "Accessors" and 3.11 "Animations" (normalised integers).

use super::LoadOptions;
use super::buffers::{Buffers, View};
use super::document::{self, Document, part};
use crate::scene::SceneError;

/// The number type of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// What an accessor may look like for the use at hand.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name in messages, e.g. `POSITION`.
    pub what: &'static str,
    /// Accepted `type`s.
    pub kinds: &'static [&'static str],
    /// Accepted integer components, with the normalised flag they must have; `f32` where `float`.
    pub integers: &'static [(Component, bool)],
    pub float: bool,
}

/// The values of an accessor, element after element.
#[derive(Clone, Debug)]
pub struct Values {
    /// Components per element.
    pub lanes: usize,
    pub data: Vec<f64>,
}

impl Values {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.data.len() / self.lanes
    }

    /// The elements as arrays of their first `N` components.
    ///
    /// # Panics
    /// When `N` is larger than [`Self::lanes`], which the [`Format`] asked for rules out.
    pub fn elements<const N: usize>(&self) -> impl ExactSizeIterator<Item = [f64; N]> {
        self.data.chunks_exact(self.lanes).map(|element| std::array::from_fn(|lane| element[lane]))
    }
}

/// Reads the accessors of one document.
#[derive(Clone, Copy, Debug)]
pub struct Accessors<'a> {
    pub document: &'a Document,
    pub buffers: &'a Buffers<'a>,
    pub options: &'a LoadOptions,
}

impl Accessors<'_> {
    /// All values of accessor `index`, which must have one of the layouts of `format`. `from` names the reference.
    ///
    /// # Errors
    /// Those of [`Self::read_as_is`]; NaN or infinite values.
    pub fn read(&self, index: u64, format: &Format, from: &str) -> Result<Values, SceneError> {
        let values = self.read_as_is(index, format, from)?;
        match values.data.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(bad) => Err(SceneError::invalid(
                format!("accessors[{index}]"),
                "ACCESSOR_INVALID_FLOAT",
                format!("{} {} is {}", format.what, bad / values.lanes, values.data[bad]),
            )),
        }
    }

    /// As [`Self::read`], but values may be NaN or infinite.
    ///
    /// # Errors
    /// Out-of-range references, sizes and offsets; another layout; absurd counts.
    pub fn read_as_is(&self, index: u64, format: &Format, from: &str) -> Result<Values, SceneError> {
        let accessor = part(&self.document.accessors, index, "accessors", from)?;
        let place = format!("accessors[{index}]");
        let component = component(accessor.component_type, &place)?;
        let lanes = self.check_format(accessor, component, format, &place)?;
        let count = self.check_count(accessor, &place)?;

        let mut values = Values { lanes, data: Vec::new() };
        match accessor.buffer_view {
            Some(view) => {
                let view = self.buffers.view(view, &place)?;
                let layout = Layout { component, lanes, offset: accessor.byte_offset, count };
                layout.decode(view, accessor.normalized, &place, &mut values.data)?;
            }
            None => {
                let limit = self.options.limits.unbacked_elements;
                if count > limit {
                    return Err(SceneError::Limit { what: "elements without data", count, limit });
                }
                values.data.resize(count as usize * lanes, 0.0);
            }
        }
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, component, accessor.normalized, &place, &mut values)?;
        }
        Ok(values)
    }

    /// Vertex indices, each less than `vertex_count`.
    ///
    /// # Errors
    /// Those of [`Self::read`], `ACCESSOR_INDEX_OOB`, and `ACCESSOR_INDEX_PRIMITIVE_RESTART` for the largest value
    /// of the type, which glTF forbids.
    pub fn read_indices(&self, index: u64, vertex_count: usize, from: &str) -> Result<Vec<u32>, SceneError> {
        const FORMAT: Format = Format {
            what: "indices",
            kinds: &["SCALAR"],
            integers: &[(Component::U8, false), (Component::U16, false), (Component::U32, false)],
            float: false,
        };
        let values = self.read(index, &FORMAT, from)?;
        let place = format!("accessors[{index}]");
        let accessor = part(&self.document.accessors, index, "accessors", from)?;
        let restart = match component(accessor.component_type, &place)? {
            Component::U8 => f64::from(u8::MAX),
            Component::U16 => f64::from(u16::MAX),
            _ => f64::from(u32::MAX),
        };
        for value in &values.data {
            if *value == restart {
                return Err(SceneError::invalid(
                    place,
                    "ACCESSOR_INDEX_PRIMITIVE_RESTART",
                    format!("index {value} would restart the primitive, which glTF does not allow"),
                ));
            }
            if *value >= vertex_count as f64 {
                return Err(SceneError::invalid(
                    place,
                    "ACCESSOR_INDEX_OOB",
                    format!("index {value}, but the mesh has {vertex_count} vertices"),
                ));
            }
        }
        Ok(values.data.iter().map(|value| *value as u32).collect())
    }

    /// The number of components per element, once kind and component type are found acceptable.
    fn check_format(
        &self,
        accessor: &document::Accessor,
        component: Component,
        format: &Format,
        place: &str,
    ) -> Result<usize, SceneError> {
        let component_fits = match component {
            Component::F32 => format.float && !accessor.normalized,
            _ => format.integers.contains(&(component, accessor.normalized)),
        };
        if !component_fits || !format.kinds.contains(&accessor.kind.as_str()) {
            let normalized = if accessor.normalized { "normalised " } else { "" };
            return Err(SceneError::invalid(
                place,
                "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                format!("{} cannot be {normalized}{component:?} {:?}", format.what, accessor.kind),
            ));
        }
        Ok(match accessor.kind.as_str() {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        })
    }

    fn check_count(&self, accessor: &document::Accessor, place: &str) -> Result<u64, SceneError> {
        if accessor.count == 0 {
            return Err(SceneError::invalid(place, "VALUE_NOT_IN_RANGE", "count is 0"));
        }
        // An index list is the longest thing an accessor holds: three per triangle.
        let limit = self.options.limits.triangles.saturating_mul(3);
        if accessor.count > limit {
            return Err(SceneError::Limit { what: "elements in one accessor", count: accessor.count, limit });
        }
        Ok(accessor.count)
    }

    fn apply_sparse(
        &self,
        sparse: &document::Sparse,
        component: Component,
        normalized: bool,
        place: &str,
        values: &mut Values,
    ) -> Result<(), SceneError> {
        let fault = |code, detail: String| SceneError::invalid(format!("{place}.sparse"), code, detail);
        if sparse.count == 0 || sparse.count > values.len() as u64 {
            return Err(fault(
                "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
                format!("count {} is not in 1..={}", sparse.count, values.len()),
            ));
        }
        let index_component = self::component(sparse.indices.component_type, place)?;
        if !matches!(index_component, Component::U8 | Component::U16 | Component::U32) {
            return Err(fault("VALUE_NOT_IN_LIST", format!("indices cannot be {index_component:?}")));
        }
        let mut indices = Vec::new();
        let view = self.buffers.view(sparse.indices.buffer_view, place)?;
        Layout {
            component: index_component,
            lanes: 1,
            offset: sparse.indices.byte_offset,
            count: sparse.count,
        }
        .decode(view, false, place, &mut indices)?;
        let mut replacements = Vec::new();
        let view = self.buffers.view(sparse.values.buffer_view, place)?;
        Layout { component, lanes: values.lanes, offset: sparse.values.byte_offset, count: sparse.count }
            .decode(view, normalized, place, &mut replacements)?;

        let lanes = values.lanes;
        let mut previous = -1.0;
        for (index, replacement) in indices.into_iter().zip(replacements.chunks_exact(lanes)) {
            if index <= previous {
                return Err(fault(
                    "ACCESSOR_SPARSE_INDICES_NON_INCREASING",
                    format!("index {index} does not exceed the one before it"),
                ));
            }
            previous = index;
            let start = index as usize * lanes;
            let target = values
                .data
                .get_mut(start..start + lanes)
                .ok_or_else(|| fault("ACCESSOR_SPARSE_INDEX_OOB", format!("index {index}")))?;
            target.copy_from_slice(replacement);
        }
        Ok(())
    }
}

fn component(code: u64, place: &str) -> Result<Component, SceneError> {
    Ok(match code {
        5120 => Component::I8,
        5121 => Component::U8,
        5122 => Component::I16,
        5123 => Component::U16,
        5125 => Component::U32,
        5126 => Component::F32,
        _ => {
            return Err(SceneError::invalid(
                place,
                "VALUE_NOT_IN_LIST",
                format!("componentType {code} is unknown"),
            ));
        }
    })
}

/// Where the elements of an accessor lie in its buffer view.
struct Layout {
    component: Component,
    lanes: usize,
    offset: u64,
    count: u64,
}

impl Layout {
    /// Appends all components to `out`, once the last byte is known to lie inside the view.
    fn decode(
        &self,
        view: View<'_>,
        normalized: bool,
        place: &str,
        out: &mut Vec<f64>,
    ) -> Result<(), SceneError> {
        let size = self.component.size();
        let element = size * self.lanes as u64;
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            return Err(SceneError::invalid(
                place,
                "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
                format!("byteStride {stride} is less than an element's {element} bytes"),
            ));
        }
        let end = (self.count - 1)
            .checked_mul(stride)
            .and_then(|last| last.checked_add(element))
            .and_then(|length| length.checked_add(self.offset));
        if end.is_none_or(|end| end > view.bytes.len() as u64) {
            return Err(SceneError::invalid(
                place,
                "ACCESSOR_TOO_LONG",
                format!(
                    "{} elements from offset {} do not fit into the {} bytes of the buffer view",
                    self.count,
                    self.offset,
                    view.bytes.len()
                ),
            ));
        }
        out.reserve(self.count as usize * self.lanes);
        for i in 0..self.count {
            let start = (self.offset + i * stride) as usize;
            let bytes = &view.bytes[start..start + element as usize];
            out.extend(
                bytes.chunks_exact(size as usize).map(|chunk| self.component.decode(chunk, normalized)),
            );
        }
        Ok(())
    }
}

impl Component {
    /// Bytes of one component.
    fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// One component from its `size` little-endian bytes; `U32` has no normalised form.
    fn decode(self, bytes: &[u8], normalized: bool) -> f64 {
        let (value, largest) = match (self, bytes) {
            (Self::I8, &[a]) => (f64::from(a as i8), f64::from(i8::MAX)),
            (Self::U8, &[a]) => (f64::from(a), f64::from(u8::MAX)),
            (Self::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX)),
            (Self::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX)),
            (Self::U32, &[a, b, c, d]) => (f64::from(u32::from_le_bytes([a, b, c, d])), 1.0),
            (Self::F32, &[a, b, c, d]) => (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0),
            _ => unreachable!("chunks have the component's size"),
        };
        if normalized { (value / largest).max(-1.0) } else { value }
    }
}
