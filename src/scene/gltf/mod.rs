//! Reading glTF 2.0 (.gltf and .glb) into a [`Scene`].
//!
//! ```text
//! container -> integers, sieve -> document -> extensions (refuse or warn) -> buffers
//!           -> nodes -> mesh -> skin -> tangents -> place     one mesh per primitive and instance, or one with instances
//!           -> camera (and lights), material -> image
//! ```
//! A file is not trusted: every index, offset, count and float is checked before use, and URIs stay in the
//! folder of the file. Faults carry the code that the Khronos glTF validator gives them. One that concerns a part costs
//! that part and is a warning (`faults`), unless the file is read strictly.

mod accessor;
mod buffers;
mod camera;
mod container;
mod document;
#[cfg(feature = "compressed")]
mod draco;
mod extensions;
mod faults;
mod image;
mod integers;
#[cfg(feature = "compressed")]
mod ktx2;
mod material;
mod mesh;
#[cfg(feature = "compressed")]
mod meshopt;
mod nodes;
mod normals;
mod options;
mod parts;
mod place;
mod sieve;
mod skin;
mod tangents;
mod unsupported;
mod uri;
mod uv_sets;

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3, DVec4};
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use serde_json::Value;

use super::{Camera, Instance, Instancing, PunctualLight, Repeated, Scene, worth_keeping};
use crate::scene::SceneError;
use accessor::Accessors;
use buffers::Buffers;
use document::Document;
use faults::Faults;
use material::MaterialTable;
use mesh::{Decompressed, Primitive, PrimitiveReader, Skipped};
use nodes::NodeTree;
use parts::{LIGHTS, VARIANTS};

pub use options::{Limits, LoadOptions};

/// Reads a .gltf or .glb file with all it refers to.
///
/// # Errors
/// A [`SceneError`] that names what is wrong; nothing is dropped without a warning in [`Scene::warnings`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let bytes = uri::read_limited(path, options)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut scene = load_slice(&bytes, Some(folder), options)?;
    scene.name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Ok(scene)
}

/// Reads the bytes of a .gltf or .glb file; relative URIs are looked up in `base_dir`, refused without one.
///
/// # Errors
/// Those of [`load`].
pub fn load_slice(bytes: &[u8], base_dir: Option<&Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let mut faults = Faults::new(options.strict);
    let container = container::split(bytes)?;
    let document = parse(&container.json, &mut faults)?;
    extensions::check_required(&document)?;
    let buffers = Buffers::load(&document, container.bin.as_deref(), base_dir, options)?;
    let mut loader = Loader {
        document: &document,
        accessors: Accessors { document: &document, buffers: &buffers, options },
        tree: NodeTree::new(&document, &mut faults)?,
        materials: MaterialTable::new(&document),
        scene: Scene::default(),
        faults,
        variant: None,
        skipped: [0; 3],
        vertices: 0,
        triangles: 0,
        options,
    };
    loader.choose_variant()?;
    extensions::warn_ignored(&document, &mut loader.faults);
    loader.add_cameras_and_lights()?;
    loader.add_meshes()?;
    loader.add_resolution();
    loader.warn_skipped();

    let Loader { mut scene, materials, mut faults, .. } = loader;
    materials.finish(&buffers, base_dir, options, &mut faults, &mut scene)?;
    scene.warnings = faults.into_warnings();
    Ok(scene)
}

/// The document, which `gltf::json` reads once integers stand where they are due and what it cannot hold is taken out.
fn parse(json: &[u8], faults: &mut Faults) -> Result<Document, SceneError> {
    let mut value: Value = serde_json::from_slice(json).map_err(|cause| SceneError::Json { cause })?;
    check_version(&value)?;
    let repaired = integers::repair(&mut value);
    if repaired.count > 0 {
        let detail = format!("written with a fraction where an integer is due, one of {}", repaired.count);
        let error = SceneError::invalid(&repaired.first, "TYPE_MISMATCH", detail);
        faults.tolerate(&repaired.first, error, "they are read as integers")?;
    }
    Document::new(value)
}

/// glTF 1.0 is told by its version, or by objects where 2.0 has lists: it did not ask for a version.
fn check_version(document: &Value) -> Result<(), SceneError> {
    let asset = &document["asset"];
    let text = |name: &str| match &asset[name] {
        Value::String(version) => Some(version.clone()),
        Value::Number(version) => Some(version.to_string()),
        _ => None,
    };
    let lists_are_objects = ["nodes", "meshes", "buffers"].iter().any(|name| document[name].is_object());
    let old = lists_are_objects.then(|| "1.0".to_string());
    let Some(version) = text("version").or(old) else {
        return Err(SceneError::invalid("asset", "UNDEFINED_PROPERTY", "the version is missing"));
    };
    let minimum = text("minVersion");
    let minimum_fits = minimum.as_deref().is_none_or(|version| version == "2.0");
    if version.split('.').next() == Some("2") && minimum_fits {
        return Ok(());
    }
    Err(SceneError::Version { version: minimum.unwrap_or(version) })
}

const DRACO: &str = "KHR_draco_mesh_compression";

/// One primitive's mesh at one node.
struct Placement<'a> {
    node: usize,
    mesh: Index<json::Mesh>,
    source: &'a json::Mesh,
    weights: &'a [f64],
}

struct Loader<'a> {
    document: &'a Document,
    accessors: Accessors<'a>,
    tree: NodeTree,
    materials: MaterialTable<'a>,
    scene: Scene,
    faults: Faults,
    /// Index of the variant whose materials are shown.
    variant: Option<u32>,
    /// Primitives not shown: points, lines, without positions.
    skipped: [usize; 3],
    /// Vertices and triangles placed so far.
    vertices: u64,
    triangles: u64,
    options: &'a LoadOptions,
}

/// Repeated meshes of fewer triangles in all are not spoken of.
const MATTERS: usize = 100_000;

/// Where a node shows its mesh.
struct Places {
    /// Of the object.
    name: Arc<str>,
    /// The node, for messages.
    place: String,
    /// To world space.
    transforms: Vec<DAffine3>,
}

/// A primitive ready to be placed, with the scene's index of its material.
struct Ready {
    primitive: Primitive,
    material: u32,
}

impl<'a> Loader<'a> {
    fn choose_variant(&mut self) -> Result<(), SceneError> {
        let whole = self.document.whole(VARIANTS);
        self.faults.or_without(VARIANTS, whole, "the file is shown without variants")?;
        let variants = self.document.variants();
        if let Some(wanted) = &self.options.variant {
            let found = variants.iter().position(|name| name == wanted).ok_or_else(|| {
                let wanted = wanted.clone();
                let list = match variants.as_slice() {
                    [] => "the file has none, so leave --variant out".into(),
                    _ => format!("the file has: {}", variants.join(", ")),
                };
                SceneError::UnknownVariant { wanted, list }
            })?;
            self.variant = Some(found as u32);
        }
        self.scene.variants = variants;
        Ok(())
    }

    /// The material of a primitive, by the variant that is shown.
    fn material_of(
        &mut self,
        source: &json::mesh::Primitive,
        place: &str,
    ) -> Result<Option<Index<json::Material>>, SceneError> {
        let whole = self.document.whole(&format!("{place}.{VARIANTS}"));
        self.faults.or_without(place, whole, "the material of no variant is used")?;
        let variants = source.extensions.as_ref().and_then(|e| e.khr_materials_variants.as_ref());
        let mut mappings = variants.into_iter().flat_map(|variants| &variants.mappings);
        let mapping = mappings.find(|mapping| self.variant.is_some_and(|v| mapping.variants.contains(&v)));
        Ok(mapping.map(|mapping| Index::new(mapping.material)).or(source.material))
    }

    fn add_cameras_and_lights(&mut self) -> Result<(), SceneError> {
        let lights = self.document.whole(LIGHTS);
        self.faults.or_without(LIGHTS, lights, "its lights are left out")?;
        for node in self.tree.shown.clone() {
            let place = format!("nodes[{node}]");
            if let Some(index) = self.document.nodes[node].camera {
                let camera = self.camera(node, index, &place);
                let camera = self.faults.or_without(&place, camera, "this camera is left out")?;
                self.scene.cameras.extend(camera);
            }
            let light = self.light(node, &place);
            let light = self.faults.or_without(&place, light, "this light is left out")?;
            self.scene.lights.extend(light.flatten());
        }
        Ok(())
    }

    fn camera(&self, node: usize, index: Index<json::Camera>, place: &str) -> Result<Camera, SceneError> {
        let source = self.document.get(index, place)?;
        let name = source.name.as_deref().or(self.document.nodes[node].name.as_deref()).unwrap_or(place);
        camera::camera(source, name, &self.tree.world[node], &format!("cameras[{}]", index.value()))
    }

    fn light(&mut self, node: usize, place: &str) -> Result<Option<PunctualLight>, SceneError> {
        let document = self.document;
        document.whole(&format!("{place}.{LIGHTS}"))?;
        let extensions = document.nodes[node].extensions.as_ref();
        let reference = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        // What is wrong with the list of lights as a whole has been said.
        let Some(index) =
            reference.map(|reference| reference.light).filter(|_| document.whole(LIGHTS).is_ok())
        else {
            return Ok(None);
        };
        let place = format!("light {} at {place}", index.value());
        let light = document.get(index, &place).map_err(|error| match error {
            // What is wrong with the light is said of where it is to shine.
            SceneError::Invalid { code, detail, .. } => SceneError::invalid(&place, code, detail),
            error => error,
        })?;
        camera::light(light, &self.tree.world[node], &place, &mut self.faults).map(Some)
    }

    fn add_meshes(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let mut placements = Vec::new();
        for &node in &self.tree.shown {
            let Some(mesh) = document.nodes[node].mesh else { continue };
            let place = format!("nodes[{node}]");
            let source = document.get(mesh, &place);
            let Some(source) = self.faults.or_without(&place, source, "it shows no mesh")? else { continue };
            let weights = document.transforms[node].weights.as_ref();
            let weights = weights.or(document.morphs[mesh.value()].weights.as_ref());
            let weights = weights.map_or(&[][..], Vec::as_slice);
            placements.push(Placement { node, mesh, source, weights });
        }
        // Nodes that show the same mesh follow each other, so that it is read once and kept no longer than needed.
        placements.sort_by_key(|placement| placement.mesh.value());

        let is_skinned = |placement: &Placement<'_>| document.nodes[placement.node].skin.is_some();
        let is_same = |a: &Placement<'_>, b: &Placement<'_>| {
            a.mesh.value() == b.mesh.value() && a.weights == b.weights && !is_skinned(a) && !is_skinned(b)
        };
        placements.chunk_by(is_same).try_for_each(|group| self.place_group(group))
    }

    /// Shows a mesh in all of its places: each primitive as copies, or once with instances.
    fn place_group(&mut self, group: &[Placement<'_>]) -> Result<(), SceneError> {
        let primitives = self.read_mesh(&group[0])?;
        let places: Vec<Places> = group.iter().map(|one| self.places(one)).collect::<Result<_, _>>()?;
        let mut shared: Vec<Vec<Instance>> = Vec::with_capacity(primitives.len());
        for Ready { primitive, material } in &primitives {
            let triangles = primitive.triangles.len();
            let is_kept = group.iter().all(|one| self.document.nodes[one.node].skin.is_none())
                && self.keeps_instances(&places, triangles, *material);
            let instances = places.iter().flat_map(|Places { name, transforms, .. }| {
                let suitable = transforms.iter().filter(|transform| is_kept && Instance::suits(transform));
                suitable.map(|&transform| Instance { transform, name: name.clone() })
            });
            shared.push(instances.collect());
        }
        for Places { name, place, transforms } in &places {
            for (Ready { primitive, material }, shared) in primitives.iter().zip(&shared) {
                self.count(primitive, transforms.len())?;
                for transform in transforms {
                    if shared.is_empty() || !Instance::suits(transform) {
                        let mesh = place::place(primitive, transform, name, *material);
                        self.scene.meshes.extend(self.faults.or_without(
                            place,
                            mesh,
                            "its mesh is left out",
                        )?);
                    }
                }
            }
        }
        for (Ready { primitive, material }, shared) in primitives.iter().zip(shared) {
            if !shared.is_empty() {
                let Places { name, place, .. } = &places[0];
                let mesh = place::share(primitive, name, *material, shared);
                self.scene.meshes.extend(self.faults.or_without(place, mesh, "its mesh is left out")?);
            }
        }
        Ok(())
    }

    /// Whether a primitive is kept once, with instances; says so where it is repeated enough for that to matter.
    fn keeps_instances(&mut self, places: &[Places], triangles: usize, material: u32) -> bool {
        let count: usize = places.iter().map(|places| places.transforms.len()).sum();
        if count < 2 || self.options.instancing == Instancing::Never {
            return false;
        }
        let worth = match self.options.instancing {
            Instancing::Always => Ok("as asked for".into()),
            _ => worth_keeping(triangles, count),
        };
        let material = &self.materials.materials[material as usize];
        let emits = material.unlit || material.emission.max_element() > 0.0;
        let kept = match worth {
            Ok(_) if emits => Err("it emits: each triangle is a light".into()),
            worth => worth,
        };
        let as_instances = kept.is_ok();
        let reason = kept.unwrap_or_else(|reason| reason);
        if as_instances || triangles * count >= MATTERS {
            let mesh = places[0].name.to_string();
            self.scene.repeated.push(Repeated { mesh, triangles, places: count, as_instances, reason });
        }
        as_instances
    }

    /// The primitives of a mesh, posed as the node has them.
    fn read_mesh(&mut self, placement: &Placement<'_>) -> Result<Vec<Ready>, SceneError> {
        let mesh = placement.source;
        let mut primitives = Vec::with_capacity(mesh.primitives.len());
        for (index, source) in mesh.primitives.iter().enumerate() {
            let place = format!("meshes[{}].primitives[{index}]", placement.mesh.value());
            let whole = self.document.whole(&place);
            let ready = whole.and_then(|()| self.read_primitive(placement, source, index, &place));
            primitives.extend(self.faults.or_without(&place, ready, "it is left out")?.flatten());
        }
        Ok(primitives)
    }

    /// A primitive as the node poses it; nothing where it is of a kind that is not shown.
    fn read_primitive(
        &mut self,
        placement: &Placement<'_>,
        source: &json::mesh::Primitive,
        index: usize,
        place: &str,
    ) -> Result<Option<Ready>, SceneError> {
        let document = self.document;
        let targets = &document.morphs[placement.mesh.value()].primitives[index].targets;
        let material = self.material_of(source, place)?;
        let material = self.materials.register(material, place, &mut self.faults)?;
        let normal_map = self.materials.materials[material as usize].normal_texture;
        let decompressed = self.decompress(source, place)?;
        let reader = PrimitiveReader {
            accessors: self.accessors,
            source,
            targets,
            decompressed: decompressed.as_ref(),
            uv_sets: self.materials.uv_sets[material as usize],
            place,
        };
        let mut primitive = match reader.read(placement.weights, normal_map.is_some(), &mut self.faults)? {
            Ok(primitive) => primitive,
            Err(skipped) => {
                self.skipped[skipped as usize] += 1;
                return Ok(None);
            }
        };
        self.warn_missing_uvs(source, material, place);
        let black = |colors: &Vec<DVec4>| colors.iter().all(|color| color.truncate() == DVec3::ZERO);
        if primitive.colors.as_ref().is_some_and(black) {
            let problem = "all vertex colours (COLOR_0) are black, and so is the surface";
            self.faults.note(place, problem, "export the mesh without them");
        }
        if let Some(skin) = document.nodes[placement.node].skin {
            self.pose(&reader, &mut primitive, skin)?;
        }
        let repaired = place::repair_normals(&mut primitive);
        if repaired > 0 {
            let problem = format!("{repaired} normals are not finite or have no length");
            self.faults.note(place, problem, "those of the triangles are used");
        }
        let turned = normals::turn_to_front(&mut primitive);
        if turned > 0 {
            let all = primitive.triangles.len();
            let problem = format!("the normals of {turned} of {all} triangles point to their backs");
            let remedy = "they are turned round; export normals and winding for the same side";
            self.faults.note(place, problem, remedy);
        }
        if let Some(normal_map) = normal_map
            && primitive.tangents.is_none()
        {
            tangents::generate(&mut primitive, normal_map.uv_set as usize)
                .map_err(|error| SceneError::invalid(place, "TANGENT_SPACE", error.to_string()))?;
        }
        Ok(Some(Ready { primitive, material }))
    }

    /// What `KHR_draco_mesh_compression` has in place of a primitive's data.
    #[cfg(feature = "compressed")]
    fn decompress(
        &self,
        source: &json::mesh::Primitive,
        place: &str,
    ) -> Result<Option<Decompressed>, SceneError> {
        let extensions = source.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(what) = document::extension::<draco::Compressed>(extensions, DRACO, place)? else {
            return Ok(None);
        };
        let bytes = self.accessors.buffers.view(what.buffer_view, place)?.bytes;
        draco::decode(&what, bytes, &self.options.limits)
            .map(Some)
            .map_err(|detail| SceneError::invalid(place, "DRACO_COMPRESSION", detail))
    }

    /// A compressed primitive whose plain accessors are empty would show as zeros.
    #[cfg(not(feature = "compressed"))]
    fn decompress(
        &self,
        source: &json::mesh::Primitive,
        place: &str,
    ) -> Result<Option<Decompressed>, SceneError> {
        let is_plain = |accessor: &Index<json::Accessor>| {
            let accessor = self.document.get(*accessor, place);
            !accessor.is_ok_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
        };
        let extensions = source.extensions.as_ref();
        let compressed = extensions.is_some_and(|extensions| extensions.others.contains_key(DRACO));
        if compressed && !source.attributes.values().all(is_plain) {
            return Err(unsupported::unsupported(&[DRACO]));
        }
        Ok(None)
    }

    fn pose(
        &mut self,
        reader: &PrimitiveReader<'_>,
        primitive: &mut Primitive,
        skin: Index<json::Skin>,
    ) -> Result<(), SceneError> {
        let world = &self.tree.world;
        let joints = skin::joint_matrices(self.document, skin, world, &self.accessors, reader.place)?;
        match reader.influences(primitive.positions.len(), joints.len(), &mut self.faults)? {
            Some(influences) => skin::pose(primitive, &influences, &joints),
            None => self.faults.note(reader.place, "skinned, but without joints", "it is not posed"),
        }
        Ok(())
    }

    /// Where a node shows its mesh.
    fn places(&mut self, placement: &Placement<'_>) -> Result<Places, SceneError> {
        let node = &self.document.nodes[placement.node];
        let name = match (&node.name, &placement.source.name) {
            (Some(name), _) | (None, Some(name)) => name.clone(),
            (None, None) => format!("mesh {}", placement.mesh.value()),
        };
        let place = format!("nodes[{}]", placement.node);
        let transforms: Vec<DAffine3> = if node.skin.is_some() {
            // Joints put a skinned mesh into the world; the transform of its node does not count.
            vec![DAffine3::IDENTITY]
        } else {
            let world = self.tree.world[placement.node];
            let instances = nodes::instances(node, placement.node, &self.accessors);
            let instances = self.faults.or_without(&place, instances, "its mesh is left out")?;
            instances.unwrap_or_default().into_iter().map(|instance| world * instance).collect()
        };
        Ok(Places { name: name.into(), place, transforms })
    }

    /// Adds to the totals, and refuses before flattening what would not fit afterwards.
    fn count(&mut self, primitive: &Primitive, copies: usize) -> Result<(), SceneError> {
        let limits = &self.options.limits;
        let copied = |count: usize| (count as u64).saturating_mul(copies as u64);
        self.vertices = self.vertices.saturating_add(copied(primitive.positions.len()));
        self.triangles = self.triangles.saturating_add(copied(primitive.triangles.len()));
        if self.vertices > limits.vertices {
            let (count, limit) = (self.vertices, limits.vertices);
            return Err(SceneError::Limit { what: "vertices", count, limit });
        }
        if self.triangles > limits.triangles {
            let (count, limit) = (self.triangles, limits.triangles);
            return Err(SceneError::Limit { what: "triangles", count, limit });
        }
        Ok(())
    }

    /// Attributes that are there but faulty have been reported.
    fn warn_missing_uvs(&mut self, source: &json::mesh::Primitive, material: u32, place: &str) {
        let uv_sets = self.materials.uv_sets[material as usize];
        let material = &self.materials.materials[material as usize];
        for (slot, set) in (0..).zip(uv_sets) {
            let wanted = material.textures().any(|texture| texture.uv_set == slot);
            if wanted && !source.attributes.contains_key(&Checked::Valid(Semantic::TexCoords(set))) {
                let name = &material.name;
                let problem = format!("its material \"{name}\" wants TEXCOORD_{set}, which is missing");
                self.faults.note(place, problem, "(0, 0) is used");
            }
        }
    }

    fn add_resolution(&mut self) {
        let extras = self.document.extras.as_ref().map(|extras| serde_json::from_str::<Value>(extras.get()));
        let Some(Ok(extras)) = extras else { return };
        let Some(value) = extras.get("resolution") else { return };
        match serde_json::from_value::<[u32; 2]>(value.clone()) {
            Ok(resolution) if resolution.iter().all(|side| *side > 0) => {
                self.scene.resolution = Some(resolution);
            }
            _ => self.faults.note(
                "extras.resolution",
                format!("{value} is not [width, height] in pixels"),
                "the default size is used",
            ),
        }
    }

    fn warn_skipped(&mut self) {
        let kinds = [
            (Skipped::Points, "primitives of points"),
            (Skipped::Lines, "primitives of lines"),
            (Skipped::NoPositions, "primitives without POSITION"),
        ];
        for (kind, what) in kinds {
            let count = self.skipped[kind as usize];
            if count > 0 {
                self.faults.note("meshes", format!("{count} {what}"), "they are not shown");
            }
        }
        // What was left out has been reported, and may be all there was.
        if self.scene.meshes.is_empty() && self.faults.is_empty() {
            self.faults.note("scene", "there is no mesh to see", "only its environment, if any, is seen");
        }
    }
}
