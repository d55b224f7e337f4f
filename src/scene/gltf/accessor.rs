//! Checked reading of glTF accessors: every component type, normalised or not, strided, sparse, or without a
//! buffer view at all (zeros).
//!
//! All arithmetic on offsets is checked `u64`; values come out as `f64`, which holds every component exactly.
//! Source of the decoding rules: glTF 2.0, 3.6.2 "Accessors" and 3.11 "Animations" (normalised integers).

use gltf::json::accessor::{Type, sparse};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};

use super::LoadOptions;
use super::buffers::{Buffers, View};
use super::document::Document;
use crate::scene::SceneError;

/// The number type of one component.
pub use gltf::json::accessor::ComponentType as Component;

/// What an accessor may look like for the use at hand.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name in messages, e.g. `POSITION`.
    pub what: &'static str,
    /// Accepted `type`s.
    pub kinds: &'static [Type],
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

/// An accessor with the place that messages name, and its layout.
struct Described<'a> {
    accessor: &'a json::Accessor,
    place: String,
    component: Component,
    lanes: usize,
}

impl Accessors<'_> {
    /// All values of accessor `index`, which must have one of the layouts of `format`. `from` names the reference.
    ///
    /// # Errors
    /// Those of [`Self::read_as_is`]; NaN or infinite values.
    pub fn read(
        &self,
        index: Index<json::Accessor>,
        format: &Format,
        from: &str,
    ) -> Result<Values, SceneError> {
        finite(self.read_as_is(index, format, from)?, format, &place(index))
    }

    /// The values of accessor `index` where another place has its components, as integers where they are some.
    ///
    /// # Errors
    /// Another layout than one of `format`, or than `components` has.
    pub fn adopt(
        &self,
        index: Index<json::Accessor>,
        components: &Values,
        format: &Format,
        from: &str,
    ) -> Result<Values, SceneError> {
        let Described { accessor, place, component, lanes } = self.describe(index, format, from)?;
        let found = (components.lanes, components.len() as u64);
        if found != (lanes, accessor.count.0) {
            let expected = (lanes, accessor.count.0);
            let detail = format!(
                "{} has {} elements of {} components, but {} of {} in the compressed mesh",
                format.what, expected.1, expected.0, found.1, found.0
            );
            return Err(SceneError::invalid(place, "ACCESSOR_COMPRESSED_COUNT", detail));
        }
        let scaled = |value: &f64| if accessor.normalized { normalize(component, *value) } else { *value };
        Ok(Values { lanes, data: components.data.iter().map(scaled).collect() })
    }

    /// What accessor `index` says of itself.
    ///
    /// # Errors
    /// An accessor that is not there, or of another layout than one of `format`.
    fn describe(
        &self,
        index: Index<json::Accessor>,
        format: &Format,
        from: &str,
    ) -> Result<Described<'_>, SceneError> {
        let accessor = self.document.get(index, from)?;
        let place = place(index);
        let component = component(accessor, &place)?;
        let lanes = self.check_format(accessor, component, format, &place)?;
        Ok(Described { accessor, place, component, lanes })
    }

    /// As [`Self::read`], but values may be NaN or infinite.
    ///
    /// # Errors
    /// Out-of-range references, sizes and offsets; another layout; absurd counts.
    pub fn read_as_is(
        &self,
        index: Index<json::Accessor>,
        format: &Format,
        from: &str,
    ) -> Result<Values, SceneError> {
        let Described { accessor, place, component, lanes } = self.describe(index, format, from)?;
        let count = self.check_count(accessor, &place)?;

        let mut values = Values { lanes, data: Vec::new() };
        match accessor.buffer_view {
            Some(view) => {
                let view = self.buffers.view(view, &place)?;
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let layout = Layout { component, lanes, offset, count };
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
    pub fn read_indices(
        &self,
        index: Index<json::Accessor>,
        vertex_count: usize,
        from: &str,
    ) -> Result<Vec<u32>, SceneError> {
        const FORMAT: Format = Format {
            what: "indices",
            kinds: &[Type::Scalar],
            integers: &[(Component::U8, false), (Component::U16, false), (Component::U32, false)],
            float: false,
        };
        let values = self.read(index, &FORMAT, from)?;
        let place = place(index);
        let restart = match component(self.document.get(index, from)?, &place)? {
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
        accessor: &json::Accessor,
        component: Component,
        format: &Format,
        place: &str,
    ) -> Result<usize, SceneError> {
        let Checked::Valid(kind) = accessor.type_ else {
            let detail = "its type is none of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 and MAT4";
            return Err(SceneError::invalid(place, FORMAT, detail));
        };
        let component_fits = match component {
            Component::F32 => format.float && !accessor.normalized,
            _ => format.integers.contains(&(component, accessor.normalized)),
        };
        if !component_fits || !format.kinds.contains(&kind) {
            let normalized = if accessor.normalized { "normalised " } else { "" };
            return Err(SceneError::invalid(
                place,
                FORMAT,
                format!("{} cannot be {normalized}{component:?} {kind:?}", format.what),
            ));
        }
        Ok(kind.multiplicity())
    }

    fn check_count(&self, accessor: &json::Accessor, place: &str) -> Result<u64, SceneError> {
        let count = accessor.count.0;
        if count == 0 {
            return Err(SceneError::invalid(place, "VALUE_NOT_IN_RANGE", "count is 0"));
        }
        // An index list is the longest thing an accessor holds: three per triangle.
        let limit = self.options.limits.triangles.saturating_mul(3);
        if count > limit {
            return Err(SceneError::Limit { what: "elements in one accessor", count, limit });
        }
        Ok(count)
    }

    fn apply_sparse(
        &self,
        sparse: &sparse::Sparse,
        component: Component,
        normalized: bool,
        place: &str,
        values: &mut Values,
    ) -> Result<(), SceneError> {
        let fault = |code, detail: String| SceneError::invalid(format!("{place}.sparse"), code, detail);
        let count = sparse.count.0;
        if count == 0 || count > values.len() as u64 {
            return Err(fault(
                "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
                format!("count {count} is not in 1..={}", values.len()),
            ));
        }
        let Checked::Valid(index_component) = &sparse.indices.component_type else {
            let detail = "the componentType of its indices is none of 5121, 5123 and 5125";
            return Err(fault("VALUE_NOT_IN_LIST", detail.into()));
        };
        let mut indices = Vec::new();
        let view = self.buffers.view(sparse.indices.buffer_view, place)?;
        Layout { component: index_component.0, lanes: 1, offset: sparse.indices.byte_offset.0, count }
            .decode(view, false, place, &mut indices)?;
        let mut replacements = Vec::new();
        let view = self.buffers.view(sparse.values.buffer_view, place)?;
        Layout { component, lanes: values.lanes, offset: sparse.values.byte_offset.0, count }.decode(
            view,
            normalized,
            place,
            &mut replacements,
        )?;

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

const FORMAT: &str = "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT";

/// The values, if all of them are finite.
pub fn finite(values: Values, format: &Format, place: &str) -> Result<Values, SceneError> {
    match values.data.iter().position(|value| !value.is_finite()) {
        None => Ok(values),
        Some(bad) => Err(SceneError::invalid(
            place,
            "ACCESSOR_INVALID_FLOAT",
            format!("{} {} is {}", format.what, bad / values.lanes, values.data[bad]),
        )),
    }
}

/// The name of an accessor in messages.
pub fn place(index: Index<json::Accessor>) -> String {
    format!("accessors[{}]", index.value())
}

fn component(accessor: &json::Accessor, place: &str) -> Result<Component, SceneError> {
    match &accessor.component_type {
        Checked::Valid(component) => Ok(component.0),
        Checked::Invalid => {
            let detail = "its componentType is none of 5120, 5121, 5122, 5123, 5125 and 5126";
            Err(SceneError::invalid(place, "VALUE_NOT_IN_LIST", detail))
        }
    }
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
        let size = self.component.size() as u64;
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
                bytes.chunks_exact(size as usize).map(|chunk| decode(self.component, chunk, normalized)),
            );
        }
        Ok(())
    }
}

/// One component from its little-endian bytes.
fn decode(component: Component, bytes: &[u8], normalized: bool) -> f64 {
    let value = match (component, bytes) {
        (Component::I8, &[a]) => f64::from(a as i8),
        (Component::U8, &[a]) => f64::from(a),
        (Component::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (Component::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (Component::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (Component::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => unreachable!("chunks have the component's size"),
    };
    if normalized { normalize(component, value) } else { value }
}

/// What an integer stands for; `U32` has no normalised form.
fn normalize(component: Component, value: f64) -> f64 {
    let largest = match component {
        Component::I8 => f64::from(i8::MAX),
        Component::U8 => f64::from(u8::MAX),
        Component::I16 => f64::from(i16::MAX),
        Component::U16 => f64::from(u16::MAX),
        Component::U32 | Component::F32 => 1.0,
    };
    (value / largest).max(-1.0)
}
