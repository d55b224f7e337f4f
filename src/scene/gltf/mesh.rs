//! Primitives in their mesh's own space: attributes, morph targets, triangles.

use glam::{DVec2, DVec3, DVec4};
use std::collections::BTreeMap;

use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;

use super::faults::Faults;
use super::parts::Attributes;
use crate::scene::SceneError;
use crate::scene::gltf::accessor::{Accessors, Component, Format, Values, finite, place};

use Component::{I8, I16, U8, U16};

/// `KHR_mesh_quantization` positions and texture coordinates.
const QUANTIZED: &[(Component, bool)] =
    &[(I8, false), (I8, true), (U8, false), (U8, true), (I16, false), (I16, true), (U16, false), (U16, true)];
const SIGNED_NORMALIZED: &[(Component, bool)] = &[(I8, true), (I16, true)];
const UNSIGNED_NORMALIZED: &[(Component, bool)] = &[(U8, true), (U16, true)];

const POSITION: Format = Format { what: "POSITION", kinds: &[Type::Vec3], integers: QUANTIZED, float: true };
const NORMAL: Format =
    Format { what: "NORMAL", kinds: &[Type::Vec3], integers: SIGNED_NORMALIZED, float: true };
const TANGENT: Format =
    Format { what: "TANGENT", kinds: &[Type::Vec4], integers: SIGNED_NORMALIZED, float: true };
const TEXCOORD: Format =
    Format { what: "TEXCOORD_n", kinds: &[Type::Vec2], integers: QUANTIZED, float: true };
/// Names of the first sets, for messages.
const TEXCOORD_NAMES: [&str; 8] = [
    "TEXCOORD_0",
    "TEXCOORD_1",
    "TEXCOORD_2",
    "TEXCOORD_3",
    "TEXCOORD_4",
    "TEXCOORD_5",
    "TEXCOORD_6",
    "TEXCOORD_7",
];
const COLOR: Format =
    Format { what: "COLOR_0", kinds: &[Type::Vec3, Type::Vec4], integers: UNSIGNED_NORMALIZED, float: true };
const WEIGHTS: Format =
    Format { what: "WEIGHTS_n", kinds: &[Type::Vec4], integers: UNSIGNED_NORMALIZED, float: true };
const JOINTS: Format =
    Format { what: "JOINTS_n", kinds: &[Type::Vec4], integers: &[(U8, false), (U16, false)], float: false };

/// A primitive in mesh space, in double precision until it stands in the world.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    pub positions: Vec<DVec3>,
    /// As the file has them, of any length.
    pub normals: Option<Vec<DVec3>>,
    /// Direction and sign of the bitangent.
    pub tangents: Option<Vec<DVec4>>,
    pub uvs: [Option<Vec<DVec2>>; 2],
    pub colors: Option<Vec<DVec4>>,
    pub triangles: Vec<[u32; 3]>,
}

/// What a compressed primitive has in place of the data of its accessors.
#[derive(Debug, Default)]
pub struct Decompressed {
    /// Components as they are stored: integers that are to be normalised are integers.
    pub attributes: BTreeMap<Checked<Semantic>, Values>,
    /// Three for each triangle, all of them in range.
    pub indices: Vec<u32>,
}

/// Joint indices and weights of the vertices, all sets side by side.
#[derive(Debug)]
pub struct Influences {
    /// Influences per vertex.
    pub lanes: usize,
    pub joints: Vec<usize>,
    pub weights: Vec<f64>,
}

/// Why a primitive shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Skipped {
    Points,
    Lines,
    NoPositions,
}

/// Reads one primitive of a document.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveReader<'a> {
    pub accessors: Accessors<'a>,
    pub source: &'a json::mesh::Primitive,
    /// Its morph targets.
    pub targets: &'a [Attributes],
    pub decompressed: Option<&'a Decompressed>,
    /// Which sets of texture coordinates to read.
    pub uv_sets: [u32; 2],
    /// Its name in messages.
    pub place: &'a str,
}

impl PrimitiveReader<'_> {
    /// Attributes and triangles, morph targets applied with `weights` (none where empty). Tangents are read only
    /// where `wants_tangents`. Attributes other than positions are left out where they are faulty.
    ///
    /// # Errors
    /// Those of [`Accessors::read`] for positions, morph targets and indices; fewer indices than a triangle has. Where
    /// strict, those of all attributes; attributes of different length; indices that make no whole triangles.
    pub fn read(
        &self,
        weights: &[f64],
        wants_tangents: bool,
        faults: &mut Faults,
    ) -> Result<Result<Primitive, Skipped>, SceneError> {
        let mode = match self.source.mode {
            Checked::Valid(Mode::Points) => return Ok(Err(Skipped::Points)),
            Checked::Valid(Mode::Lines | Mode::LineLoop | Mode::LineStrip) => return Ok(Err(Skipped::Lines)),
            Checked::Valid(mode) => mode,
            Checked::Invalid => {
                return Err(self.fault("VALUE_NOT_IN_LIST", "its mode is not in 0..=6".into()));
            }
        };
        let Some(positions) = self.own(Semantic::Positions, &POSITION, None)? else {
            return Ok(Err(Skipped::NoPositions));
        };
        let count = positions.len();
        let mut primitive = Primitive {
            positions: positions.elements().map(DVec3::from_array).collect(),
            normals: self.normals(count, faults)?,
            ..Primitive::default()
        };
        let mut optional = |semantic, format: &Format, remedy| {
            let read = self.own(semantic, format, Some(count));
            faults.or_without(self.place, read, remedy).map(Option::flatten)
        };
        if wants_tangents && primitive.normals.is_some() {
            let tangents =
                optional(Semantic::Tangents, &TANGENT, "tangents are computed from the texture coordinates")?;
            primitive.tangents = tangents.map(|values| values.elements().map(DVec4::from_array).collect());
        }
        for (uvs, set) in primitive.uvs.iter_mut().zip(self.uv_sets) {
            let values = optional(Semantic::TexCoords(set), &texcoord(set), "(0, 0) is used")?;
            *uvs = values.map(|values| values.elements().map(DVec2::from_array).collect());
        }
        let colors = optional(Semantic::Colors(0), &COLOR, "its vertices are white")?;
        primitive.colors = colors.as_ref().map(with_alpha);
        self.apply_targets(&mut primitive, weights, faults)?;
        primitive.triangles = self.triangles(mode, count, faults)?;
        Ok(Ok(primitive))
    }

    /// Normals as the file has them; zero where they are not finite, which is repaired once the vertices have their
    /// places.
    fn normals(&self, count: usize, faults: &mut Faults) -> Result<Option<Vec<DVec3>>, SceneError> {
        let read = match faults.is_strict() {
            true => self.own(Semantic::Normals, &NORMAL, Some(count)),
            false => self.own_as_is(Semantic::Normals, &NORMAL, Some(count)),
        };
        let values = faults.or_without(self.place, read, "those of its triangles are used")?.flatten();
        let finite = |normal: DVec3| if normal.is_finite() { normal } else { DVec3::ZERO };
        Ok(values.map(|values| values.elements().map(|normal| finite(DVec3::from_array(normal))).collect()))
    }

    /// Joints and weights; `None` where the primitive has none. A vertex without any weight goes with its first joint.
    ///
    /// # Errors
    /// Those of [`Accessors::read`]; joints not below `joint_count`; where strict, vertices without any weight.
    pub fn influences(
        &self,
        vertex_count: usize,
        joint_count: usize,
        faults: &mut Faults,
    ) -> Result<Option<Influences>, SceneError> {
        let mut sets = Vec::new();
        for set in 0.. {
            let read = |semantic, format| self.own(semantic, format, Some(vertex_count));
            let joints = read(Semantic::Joints(set), &JOINTS)?;
            let weights = read(Semantic::Weights(set), &WEIGHTS)?;
            match (joints, weights) {
                (Some(joints), Some(weights)) => sets.push((joints, weights)),
                (None, None) => break,
                _ => {
                    return Err(self.fault(
                        "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
                        format!("JOINTS_{set} and WEIGHTS_{set} come only together"),
                    ));
                }
            }
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let lanes = 4 * sets.len();
        let mut influences = Influences {
            lanes,
            joints: Vec::with_capacity(vertex_count * lanes),
            weights: Vec::with_capacity(vertex_count * lanes),
        };
        let mut weightless = Vec::new();
        for vertex in 0..vertex_count {
            let start = influences.weights.len();
            for (joints, weights) in &sets {
                let lanes = 4 * vertex..4 * vertex + 4;
                influences.joints.extend(joints.data[lanes.clone()].iter().map(|joint| *joint as usize));
                influences.weights.extend_from_slice(&weights.data[lanes]);
            }
            let weights = &mut influences.weights[start..];
            let mut sum: f64 = weights.iter().sum();
            if weights.iter().any(|weight| *weight < 0.0) || sum <= 0.0 {
                weightless.push(vertex);
                weights.iter_mut().for_each(|weight| *weight = weight.max(0.0));
                if weights.iter().all(|weight| *weight == 0.0) {
                    weights[0] = 1.0;
                }
                sum = weights.iter().sum();
            }
            weights.iter_mut().for_each(|weight| *weight /= sum);
            // Unused influences may name any joint; glTF wants 0 there, exporters differ.
            for (joint, weight) in influences.joints[start..].iter_mut().zip(weights) {
                if *weight == 0.0 {
                    *joint = 0;
                } else if *joint >= joint_count {
                    return Err(self.fault(
                        "ACCESSOR_JOINTS_INDEX_OOB",
                        format!("joint {joint}, but the skin has {joint_count}"),
                    ));
                }
            }
        }
        if let Some(first) = weightless.first() {
            let error = self.fault(
                "ACCESSOR_WEIGHTS_NON_NORMALIZED",
                format!("vertex {first} has no or a negative weight, one of {}", weightless.len()),
            );
            let remedy = "negative weights count as none, and vertices without any go with their first joint";
            faults.tolerate(self.place, error, remedy)?;
        }
        Ok(Some(influences))
    }

    /// One of the primitive's own attributes, all of it finite.
    fn own(
        &self,
        semantic: Semantic,
        format: &Format,
        count: Option<usize>,
    ) -> Result<Option<Values>, SceneError> {
        let values = self.own_as_is(semantic.clone(), format, count)?;
        let accessor = self.source.attributes.get(&Checked::Valid(semantic));
        let place = accessor.map_or_else(|| self.place.into(), |accessor| place(*accessor));
        values.map(|values| finite(values, format, &place)).transpose()
    }

    /// One of the primitive's own attributes, from its accessor or from where it was compressed.
    fn own_as_is(
        &self,
        semantic: Semantic,
        format: &Format,
        count: Option<usize>,
    ) -> Result<Option<Values>, SceneError> {
        let semantic = Checked::Valid(semantic);
        let Some(&accessor) = self.source.attributes.get(&semantic) else { return Ok(None) };
        let values = match self.decompressed.and_then(|all| all.attributes.get(&semantic)) {
            Some(components) => self.accessors.adopt(accessor, components, format, self.place)?,
            None => self.accessors.read_as_is(accessor, format, self.place)?,
        };
        self.counted(format.what, values, count).map(Some)
    }

    fn attribute(
        &self,
        attributes: &Attributes,
        semantic: Semantic,
        format: &Format,
        count: Option<usize>,
    ) -> Result<Option<Values>, SceneError> {
        let Some(&accessor) = attributes.get(&Checked::Valid(semantic)) else { return Ok(None) };
        let values = self.accessors.read(accessor, format, self.place)?;
        self.counted(format.what, values, count).map(Some)
    }

    /// The values, if there are as many as asked for.
    fn counted(&self, name: &str, values: Values, count: Option<usize>) -> Result<Values, SceneError> {
        match count {
            Some(count) if count != values.len() => Err(self.fault(
                "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
                format!("{name} has {} elements, POSITION has {count}", values.len()),
            )),
            _ => Ok(values),
        }
    }

    fn vectors(
        &self,
        attributes: &Attributes,
        semantic: Semantic,
        format: &Format,
        count: usize,
    ) -> Result<Option<Vec<DVec3>>, SceneError> {
        let values = self.attribute(attributes, semantic, format, Some(count))?;
        Ok(values.map(|values| values.elements().map(DVec3::from_array).collect()))
    }

    fn apply_targets(
        &self,
        primitive: &mut Primitive,
        weights: &[f64],
        faults: &mut Faults,
    ) -> Result<(), SceneError> {
        let targets = self.targets;
        if !weights.is_empty() && weights.len() != targets.len() {
            let error = self.fault(
                "MESH_INVALID_WEIGHTS_COUNT",
                format!("{} weights for {} morph targets", weights.len(), targets.len()),
            );
            faults.tolerate(self.place, error, "those that have no counterpart are left out")?;
        }
        let delta = |what, kinds| Format { what, kinds, integers: QUANTIZED, float: true };
        let count = primitive.positions.len();
        for (target, &weight) in targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let vec3 = |semantic, what| self.vectors(target, semantic, &delta(what, &[Type::Vec3]), count);
            if let Some(deltas) = vec3(Semantic::Positions, "POSITION")? {
                primitive.positions.iter_mut().zip(deltas).for_each(|(p, d)| *p += weight * d);
            }
            if let (Some(normals), Some(deltas)) =
                (&mut primitive.normals, vec3(Semantic::Normals, "NORMAL")?)
            {
                normals.iter_mut().zip(deltas).for_each(|(n, d)| *n += weight * d);
            }
            if let (Some(tangents), Some(deltas)) =
                (&mut primitive.tangents, vec3(Semantic::Tangents, "TANGENT")?)
            {
                tangents.iter_mut().zip(deltas).for_each(|(t, d)| *t += (weight * d).extend(0.0));
            }
            for (uvs, set) in primitive.uvs.iter_mut().zip(self.uv_sets) {
                let format = delta(texcoord(set).what, &[Type::Vec2]);
                let deltas = self.attribute(target, Semantic::TexCoords(set), &format, Some(count))?;
                if let (Some(uvs), Some(deltas)) = (uvs, deltas) {
                    let deltas = deltas.elements().map(DVec2::from_array);
                    uvs.iter_mut().zip(deltas).for_each(|(uv, d)| *uv += weight * d);
                }
            }
            let format = delta("COLOR_0", &[Type::Vec3, Type::Vec4]);
            let deltas = self.attribute(target, Semantic::Colors(0), &format, Some(count))?;
            if let (Some(colors), Some(deltas)) = (&mut primitive.colors, deltas) {
                for (color, delta) in colors.iter_mut().zip(deltas.data.chunks_exact(deltas.lanes)) {
                    for (lane, d) in delta.iter().enumerate() {
                        color[lane] += weight * d;
                    }
                    *color = color.clamp(DVec4::ZERO, DVec4::ONE);
                }
            }
        }
        if !primitive.positions.iter().all(|p| p.as_vec3().is_finite()) {
            return Err(
                self.fault("ACCESSOR_INVALID_FLOAT", "morph targets move a vertex to infinity".into())
            );
        }
        Ok(())
    }

    /// glTF 2.0, 3.7.2.1 "Overview": how strips and fans run; both keep the winding of their first triangle.
    fn triangles(
        &self,
        mode: Mode,
        vertex_count: usize,
        faults: &mut Faults,
    ) -> Result<Vec<[u32; 3]>, SceneError> {
        let (mode, indices) = match (self.decompressed, self.source.indices) {
            (Some(decompressed), _) => (Mode::Triangles, decompressed.indices.clone()),
            (None, Some(accessor)) => {
                (mode, self.accessors.read_indices(accessor, vertex_count, self.place)?)
            }
            (None, None) => (mode, (0..vertex_count as u32).collect()),
        };
        let separate = mode == Mode::Triangles;
        let rest = if separate { indices.len() % 3 } else { 0 };
        if indices.len() < 3 || rest > 0 {
            let error = self.fault(
                "MESH_PRIMITIVE_INCOMPATIBLE_MODE",
                format!("{} vertices do not make whole triangles", indices.len()),
            );
            if indices.len() < 3 {
                return Err(error);
            }
            faults.tolerate(self.place, error, &format!("the last {rest} are left out"))?;
        }
        let count = if separate { indices.len() / 3 } else { indices.len() - 2 };
        let corner = |i: usize| match mode {
            Mode::Triangles => [indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]],
            Mode::TriangleStrip => [indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]],
            _ => [indices[i + 1], indices[i + 2], indices[0]],
        };
        Ok((0..count).map(corner).collect())
    }

    fn fault(&self, code: &'static str, detail: String) -> SceneError {
        SceneError::invalid(self.place, code, detail)
    }
}

/// The layout of a set of texture coordinates.
fn texcoord(set: u32) -> Format {
    let what = TEXCOORD_NAMES.get(set as usize).copied().unwrap_or(TEXCOORD.what);
    Format { what, ..TEXCOORD }
}

/// Colours with their alpha, 1 where the file has none.
fn with_alpha(values: &Values) -> Vec<DVec4> {
    if values.lanes == 4 {
        values.elements().map(DVec4::from_array).collect()
    } else {
        values.elements().map(|rgb| DVec3::from_array(rgb).extend(1.0)).collect()
    }
}
