//! The node tree: which nodes the scene shows, and where each one stands in the world.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::document::{Document, Node, at, extension};
use crate::scene::SceneError;
use crate::scene::gltf::accessor::{Accessors, Component, Format};

/// A tree deeper than this is refused.
const MAX_DEPTH: usize = 1024;

const NO_NORMALIZED: &[(Component, bool)] = &[];
const QUATERNIONS: &[(Component, bool)] = &[(Component::I8, true), (Component::I16, true)];

/// All nodes with their world transforms.
#[derive(Debug)]
pub struct NodeTree {
    /// World transform of each node of the document.
    pub world: Vec<DAffine3>,
    /// The nodes of the scene to be shown, parents before children.
    pub shown: Vec<usize>,
}

#[derive(serde::Deserialize)]
struct Instancing {
    attributes: serde_json::Map<String, serde_json::Value>,
}

impl NodeTree {
    /// Walks the tree without recursion. The scene shown is `scene`, else the first, else all root nodes.
    ///
    /// # Errors
    /// Dangling references, a node with two parents, loops, more than 1024 levels, transforms that are not finite.
    pub fn new(document: &Document) -> Result<Self, SceneError> {
        let parents = parents(document)?;
        let mut world = vec![DAffine3::IDENTITY; document.nodes.len()];
        let mut reached = vec![false; document.nodes.len()];
        let roots = (0..document.nodes.len()).filter(|&node| parents[node].is_none());
        let mut stack: Vec<(usize, DAffine3, usize)> =
            roots.map(|node| (node, DAffine3::IDENTITY, 1)).collect();
        while let Some((node, parent, depth)) = stack.pop() {
            if depth > MAX_DEPTH {
                return Err(fault(node, "NODE_DEPTH", format!("the tree has more than {MAX_DEPTH} levels")));
            }
            reached[node] = true;
            world[node] = parent * local_transform(&document.nodes[node], node)?;
            if !world[node].is_finite() {
                return Err(fault(node, "VALUE_NOT_IN_RANGE", "its world transform is not finite"));
            }
            for &child in &document.nodes[node].children {
                stack.push((child as usize, world[node], depth + 1));
            }
        }
        // With at most one parent each, a node that no root reaches is part of a loop.
        if let Some(node) = reached.iter().position(|reached| !reached) {
            return Err(fault(node, "NODE_LOOP", "it is its own ancestor"));
        }
        Ok(Self { world, shown: shown(document, &parents)? })
    }
}

/// The one parent of each node.
fn parents(document: &Document) -> Result<Vec<Option<usize>>, SceneError> {
    let mut parents = vec![None; document.nodes.len()];
    for (node, source) in document.nodes.iter().enumerate() {
        for &child in &source.children {
            at(&document.nodes, child, "nodes", &format!("nodes[{node}].children"))?;
            if let Some(other) = parents[child as usize].replace(node) {
                return Err(fault(
                    child as usize,
                    "NODE_PARENT_OVERRIDE",
                    format!("nodes {other} and {node} both have it as a child"),
                ));
            }
        }
    }
    Ok(parents)
}

fn shown(document: &Document, parents: &[Option<usize>]) -> Result<Vec<usize>, SceneError> {
    let scene = match document.scene {
        Some(index) => Some(at(&document.scenes, index, "scenes", "scene")?),
        None => document.scenes.first(),
    };
    let roots: Vec<usize> = match scene {
        None => (0..document.nodes.len()).filter(|&node| parents[node].is_none()).collect(),
        Some(scene) => {
            let place = format!("scene {:?}", scene.name.as_deref().unwrap_or(""));
            let mut roots = Vec::new();
            for &root in &scene.nodes {
                at(&document.nodes, root, "nodes", &place)?;
                let root = root as usize;
                if parents[root].is_some() {
                    return Err(fault(root, "SCENE_NON_ROOT_NODE", "a scene lists it, but it has a parent"));
                }
                if !roots.contains(&root) {
                    roots.push(root);
                }
            }
            roots
        }
    };
    let mut shown = Vec::new();
    let mut stack: Vec<usize> = roots.into_iter().rev().collect();
    while let Some(node) = stack.pop() {
        shown.push(node);
        stack.extend(document.nodes[node].children.iter().rev().map(|&child| child as usize));
    }
    Ok(shown)
}

fn local_transform(node: &Node, index: usize) -> Result<DAffine3, SceneError> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix);
        if matrix.row(3) != glam::DVec4::W {
            return Err(fault(index, "NODE_MATRIX_NON_TRS", "the last row of its matrix is not 0 0 0 1"));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => quaternion(rotation)
            .ok_or_else(|| fault(index, "ROTATION_NON_UNIT", "its rotation has no length"))?,
    };
    Ok(DAffine3::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, DVec3::from),
        rotation,
        node.translation.map_or(DVec3::ZERO, DVec3::from),
    ))
}

/// A unit quaternion from x, y, z, w of any length but zero.
fn quaternion(xyzw: [f64; 4]) -> Option<DQuat> {
    let length = DQuat::from_array(xyzw).length();
    (length.is_normal()).then(|| DQuat::from_array(xyzw.map(|x| x / length)))
}

/// The places at which a node shows its mesh, in the node's own space: one, or as many as
/// `EXT_mesh_gpu_instancing` has.
///
/// # Errors
/// Those of [`Accessors::read`]; attributes of different length.
pub fn instances(node: &Node, index: usize, accessors: &Accessors<'_>) -> Result<Vec<DAffine3>, SceneError> {
    let place = format!("nodes[{index}].extensions.EXT_mesh_gpu_instancing");
    let Some(Instancing { attributes }) =
        extension(&node.extensions, "EXT_mesh_gpu_instancing", &format!("nodes[{index}]"))?
    else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let read = |what, kinds, integers| {
        let Some(accessor) = attributes.get(what) else { return Ok(None) };
        let accessor = accessor.as_u64().ok_or_else(|| {
            SceneError::invalid(&place, "TYPE_MISMATCH", format!("{what} is no accessor index"))
        })?;
        accessors.read(accessor, &Format { what, kinds, integers, float: true }, &place).map(Some)
    };
    let translations = read("TRANSLATION", &["VEC3"], NO_NORMALIZED)?;
    let rotations = read("ROTATION", &["VEC4"], QUATERNIONS)?;
    let scales = read("SCALE", &["VEC3"], NO_NORMALIZED)?;
    let counts: Vec<usize> =
        [&translations, &rotations, &scales].into_iter().flatten().map(|values| values.len()).collect();
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|other| *other != count) || count == 0 {
        return Err(SceneError::invalid(
            place,
            "MESH_INSTANCING_UNEQUAL_COUNT",
            "TRANSLATION, ROTATION and SCALE must exist in equal number",
        ));
    }
    let mut transforms = vec![DAffine3::IDENTITY; count];
    if let Some(translations) = translations {
        for (transform, translation) in transforms.iter_mut().zip(translations.elements::<3>()) {
            transform.translation = DVec3::from(translation);
        }
    }
    if let Some(rotations) = rotations {
        for (transform, rotation) in transforms.iter_mut().zip(rotations.elements::<4>()) {
            let rotation = quaternion(rotation).ok_or_else(|| {
                SceneError::invalid(&place, "ROTATION_NON_UNIT", "a rotation has no length")
            })?;
            transform.matrix3 = DMat3::from_quat(rotation);
        }
    }
    if let Some(scales) = scales {
        for (transform, scale) in transforms.iter_mut().zip(scales.elements::<3>()) {
            transform.matrix3 *= DMat3::from_diagonal(DVec3::from(scale));
        }
    }
    Ok(transforms)
}

fn fault(node: usize, code: &'static str, detail: impl Into<String>) -> SceneError {
    SceneError::invalid(format!("nodes[{node}]"), code, detail)
}
