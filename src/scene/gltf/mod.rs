//! Reading glTF 2.0 (.gltf and .glb) into a [`Scene`].
//!
//! ```text
//! container -> document -> extensions (refuse or warn) -> buffers
//!           -> nodes -> mesh -> skin -> tangents -> place     one mesh per primitive and instance
//!           -> camera (and lights), material -> image
//! ```
//! A file is not trusted: every index, offset, count and float is checked before use, and URIs stay in the
//! folder of the file. Faults carry the code that the Khronos glTF validator gives them.

mod accessor;
mod buffers;
mod camera;
mod container;
mod document;
mod extensions;
mod image;
mod material;
mod mesh;
mod nodes;
mod options;
mod place;
mod skin;
mod tangents;
mod uri;

use std::path::Path;

use glam::{DAffine3, DVec3, DVec4};

use super::Scene;
use crate::scene::SceneError;
use accessor::Accessors;
use buffers::Buffers;
use document::{Document, at};
use material::MaterialTable;
use mesh::{Primitive, PrimitiveReader, Skipped};
use nodes::NodeTree;

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
    let container = container::split(bytes)?;
    let document: Document =
        serde_json::from_slice(container.json).map_err(|cause| malformed(container.json, cause))?;
    check_version(&document)?;
    extensions::check_required(&document)?;
    let buffers = Buffers::load(&document, container.bin, base_dir, options)?;
    let mut loader = Loader {
        document: &document,
        accessors: Accessors { document: &document, buffers: &buffers, options },
        tree: NodeTree::new(&document)?,
        materials: MaterialTable::new(&document),
        scene: Scene::default(),
        skipped: [0; 3],
        vertices: 0,
        triangles: 0,
        options,
    };
    extensions::warn_ignored(&document, &mut loader.scene.warnings);
    loader.add_cameras_and_lights()?;
    loader.add_meshes()?;
    loader.add_resolution();
    loader.warn_skipped();

    let Loader { mut scene, materials, .. } = loader;
    scene.images = materials.textures.decode_images(&buffers, base_dir, options, &mut scene.warnings)?;
    scene.textures = materials.textures.textures;
    scene.materials = materials.materials;
    Ok(scene)
}

/// JSON of another shape than that of glTF 2.0: it may be glTF 1.0, where the lists of the root are objects and the version
/// may be left out.
fn malformed(json: &[u8], cause: serde_json::Error) -> SceneError {
    let value: serde_json::Value = serde_json::from_slice(json).unwrap_or_default();
    let lists = ["accessors", "meshes", "nodes", "scenes"].map(|name| &value[name]);
    match value["asset"]["version"].as_str() {
        Some(version) if version.split('.').next() != Some("2") => {
            SceneError::Version { version: version.into() }
        }
        None if lists.iter().any(|list| list.is_object()) => SceneError::Version { version: "1.0".into() },
        _ => SceneError::Json { cause },
    }
}

fn check_version(document: &Document) -> Result<(), SceneError> {
    let asset = &document.asset;
    let minimum_fits = asset.min_version.as_deref().is_none_or(|version| version == "2.0");
    if asset.version.split('.').next() == Some("2") && minimum_fits {
        return Ok(());
    }
    Err(SceneError::Version { version: asset.min_version.as_ref().unwrap_or(&asset.version).clone() })
}

/// One primitive's mesh at one node.
struct Placement<'a> {
    node: usize,
    mesh: u64,
    weights: &'a [f64],
}

struct Loader<'a> {
    document: &'a Document,
    accessors: Accessors<'a>,
    tree: NodeTree,
    materials: MaterialTable<'a>,
    scene: Scene,
    /// Primitives not shown: points, lines, without positions.
    skipped: [usize; 3],
    /// Vertices and triangles placed so far.
    vertices: u64,
    triangles: u64,
    options: &'a LoadOptions,
}

/// A primitive ready to be placed, with the scene's index of its material.
struct Ready {
    primitive: Primitive,
    material: u32,
}

impl<'a> Loader<'a> {
    fn add_cameras_and_lights(&mut self) -> Result<(), SceneError> {
        let lights = camera::light_list(&self.document.extensions)?;
        for &node in &self.tree.shown {
            let source = &self.document.nodes[node];
            let world = &self.tree.world[node];
            let place = format!("nodes[{node}]");
            if let Some(index) = source.camera {
                let camera = at(&self.document.cameras, index, "cameras", &place)?;
                let name = camera.name.as_ref().or(source.name.as_ref()).unwrap_or(&place);
                let place = format!("cameras[{index}]");
                self.scene.cameras.push(camera::camera(camera, name, world, &place)?);
            }
            if let Some(index) = camera::light_of(&source.extensions, &place)? {
                let light = at(&lights, index, "KHR_lights_punctual.lights", &place)?;
                let place = format!("light {index} at {place}");
                if light.range.is_some() {
                    self.scene
                        .warnings
                        .push(format!("{place}: its range is ignored, it lights any distance"));
                }
                self.scene.lights.push(camera::light(light, world, &place)?);
            }
        }
        Ok(())
    }

    fn add_meshes(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let mut placements = Vec::new();
        for &node in &self.tree.shown {
            let Some(mesh) = document.nodes[node].mesh else { continue };
            let source = at(&document.meshes, mesh, "meshes", &format!("nodes[{node}]"))?;
            let weights = document.nodes[node].weights.as_ref().or(source.weights.as_ref());
            placements.push(Placement { node, mesh, weights: weights.map_or(&[], Vec::as_slice) });
        }
        // Nodes that show the same mesh follow each other, so that it is read once and kept no longer than needed.
        placements.sort_by_key(|placement| placement.mesh);

        let mut read: Option<(&Placement<'_>, Vec<Ready>)> = None;
        for placement in &placements {
            let node = &document.nodes[placement.node];
            let reusable = read.as_ref().is_some_and(|(other, _)| {
                let skinned = node.skin.is_some() || document.nodes[other.node].skin.is_some();
                other.mesh == placement.mesh && other.weights == placement.weights && !skinned
            });
            if !reusable {
                read = Some((placement, self.read_mesh(placement)?));
            }
            if let Some((_, primitives)) = &read {
                self.place_mesh(placement, primitives)?;
            }
        }
        Ok(())
    }

    /// The primitives of a mesh, posed as the node has them.
    fn read_mesh(&mut self, placement: &Placement<'_>) -> Result<Vec<Ready>, SceneError> {
        let document = self.document;
        let mesh = &document.meshes[placement.mesh as usize];
        let mut primitives = Vec::with_capacity(mesh.primitives.len());
        for (index, source) in mesh.primitives.iter().enumerate() {
            let place = format!("meshes[{}].primitives[{index}]", placement.mesh);
            let material = self.materials.register(source.material, &place, &mut self.scene.warnings)?;
            let normal_map = self.materials.materials[material as usize].normal_texture;
            let reader = PrimitiveReader { document, accessors: self.accessors, source, place: &place };
            let mut primitive = match reader.read(placement.weights, normal_map.is_some())? {
                Ok(primitive) => primitive,
                Err(skipped) => {
                    self.skipped[skipped as usize] += 1;
                    continue;
                }
            };
            self.warn_missing_uvs(&primitive, material, &place);
            self.warn_black_colors(&primitive, &place);
            if let Some(skin) = document.nodes[placement.node].skin {
                self.pose(&reader, &mut primitive, skin)?;
            }
            let repaired = place::repair_normals(&mut primitive);
            if repaired > 0 {
                self.scene.warnings.push(format!(
                    "{place}: {repaired} normals have no length; those of the triangles are used"
                ));
            }
            if let Some(normal_map) = normal_map
                && primitive.tangents.is_none()
            {
                tangents::generate(&mut primitive, normal_map.uv_set as usize)
                    .map_err(|error| SceneError::invalid(&place, "TANGENT_SPACE", error.to_string()))?;
            }
            primitives.push(Ready { primitive, material });
        }
        Ok(primitives)
    }

    fn warn_black_colors(&mut self, primitive: &Primitive, place: &str) {
        let black = |colors: &Vec<DVec4>| colors.iter().all(|color| color.truncate() == DVec3::ZERO);
        if primitive.colors.as_ref().is_some_and(black) {
            self.scene.warnings.push(format!(
                "{place}: all vertex colours (COLOR_0) are black, and so is the surface; export the mesh without them"
            ));
        }
    }

    fn pose(
        &mut self,
        reader: &PrimitiveReader<'_>,
        primitive: &mut Primitive,
        skin: u64,
    ) -> Result<(), SceneError> {
        let world = &self.tree.world;
        let joints = skin::joint_matrices(self.document, skin, world, &self.accessors, reader.place)?;
        match reader.influences(primitive.positions.len(), joints.len())? {
            Some(influences) => skin::pose(primitive, &influences, &joints),
            None => self.scene.warnings.push(format!("{}: skinned, but without joints", reader.place)),
        }
        Ok(())
    }

    fn place_mesh(&mut self, placement: &Placement<'_>, primitives: &[Ready]) -> Result<(), SceneError> {
        let node = &self.document.nodes[placement.node];
        let mesh = &self.document.meshes[placement.mesh as usize];
        let name = match (&node.name, &mesh.name) {
            (Some(name), _) | (None, Some(name)) => name.clone(),
            (None, None) => format!("mesh {}", placement.mesh),
        };
        let transforms: Vec<DAffine3> = if node.skin.is_some() {
            // Joints put a skinned mesh into the world; the transform of its node does not count.
            vec![DAffine3::IDENTITY]
        } else {
            let world = self.tree.world[placement.node];
            let instances = nodes::instances(node, placement.node, &self.accessors)?;
            instances.into_iter().map(|instance| world * instance).collect()
        };
        for Ready { primitive, material } in primitives {
            self.count(primitive, transforms.len())?;
            for transform in &transforms {
                self.scene.meshes.push(place::place(primitive, transform, &name, *material)?);
            }
        }
        Ok(())
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

    fn warn_missing_uvs(&mut self, primitive: &Primitive, material: u32, place: &str) {
        let material = &self.materials.materials[material as usize];
        for (set, uvs) in primitive.uvs.iter().enumerate() {
            if uvs.is_none() && material.textures().any(|texture| texture.uv_set as usize == set) {
                self.scene.warnings.push(format!(
                    "{place}: its material \"{}\" wants TEXCOORD_{set}, which is missing; (0, 0) is used",
                    material.name
                ));
            }
        }
    }

    fn add_resolution(&mut self) {
        let Some(value) = self.document.extras.get("resolution") else { return };
        match serde_json::from_value::<[u32; 2]>(value.clone()) {
            Ok(resolution) if resolution.iter().all(|side| *side > 0) => {
                self.scene.resolution = Some(resolution);
            }
            _ => self.scene.warnings.push(format!("extras.resolution {value} is not [width, height]")),
        }
    }

    fn warn_skipped(&mut self) {
        let kinds = [
            (Skipped::Points, "primitives of points are not shown"),
            (Skipped::Lines, "primitives of lines are not shown"),
            (Skipped::NoPositions, "primitives without POSITION are not shown"),
        ];
        for (kind, what) in kinds {
            let count = self.skipped[kind as usize];
            if count > 0 {
                self.scene.warnings.push(format!("{count} {what}"));
            }
        }
        if self.scene.meshes.is_empty() {
            self.scene.warnings.push("there is no mesh to see in the scene".into());
        }
    }
}
