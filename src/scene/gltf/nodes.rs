//! The node tree: which nodes the scene shows, and where each one stands in the world.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json::accessor::Type;
use gltf::json::{self, Index};

use super::document::{Document, extension};
use super::faults::Faults;
use super::parts::Transform;
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
    attributes: BTreeMap<String, Index<json::Accessor>>,
}

#[derive(serde::Deserialize)]
struct Visibility {
    visible: Option<bool>,
}

impl NodeTree {
    /// Walks the tree without recursion. The scene shown is `scene`, else the first, else all root nodes. A node that
    /// has no place is left out with all below it.
    ///
    /// # Errors
    /// More than 1024 levels; where strict, dangling references, a node with two parents, loops, nodes that a scene
    /// lists although they have a parent, rotations without length, transforms that are not finite.
    pub fn new(document: &Document, faults: &mut Faults) -> Result<Self, SceneError> {
        let family = Family::new(document, faults)?;
        let count = document.nodes.len();
        let mut world = vec![DAffine3::IDENTITY; count];
        let mut reached = vec![false; count];
        let mut placed = vec![false; count];
        let roots = (0..count).filter(|&node| family.parents[node].is_none());
        let mut stack: Vec<(usize, Option<DAffine3>, usize)> =
            roots.map(|node| (node, Some(DAffine3::IDENTITY), 1)).collect();
        while let Some((node, parent, depth)) = stack.pop() {
            if depth > MAX_DEPTH {
                return Err(fault(node, "NODE_DEPTH", format!("the tree has more than {MAX_DEPTH} levels")));
            }
            reached[node] = true;
            let mut transform = None;
            if let Some(parent) = parent {
                let product = parent * local_transform(&document.transforms[node], node, faults)?;
                if product.is_finite() {
                    (world[node], placed[node]) = (product, true);
                    transform = Some(product);
                } else {
                    let error = fault(node, "VALUE_NOT_IN_RANGE", "its world transform is not finite");
                    faults.tolerate(&place(node), error, LEFT_OUT)?;
                }
            }
            stack.extend(family.children[node].iter().map(|&child| (child, transform, depth + 1)));
        }
        family.find_loops(reached, faults)?;
        Ok(Self { world, shown: shown(document, &family, &placed, faults)? })
    }
}

const LEFT_OUT: &str = "it is left out with all below it";

/// Which node hangs from which. No node has two parents.
struct Family {
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

impl Family {
    fn new(document: &Document, faults: &mut Faults) -> Result<Self, SceneError> {
        let count = document.nodes.len();
        let mut family = Self { parents: vec![None; count], children: vec![Vec::new(); count] };
        for (node, source) in document.nodes.iter().enumerate() {
            for &child in source.children.iter().flatten() {
                let found = document.get(child, &format!("nodes[{node}].children"));
                if faults.or_without(&place(node), found, "that child is left out")?.is_none() {
                    continue;
                }
                let child = child.value();
                if let Some(other) = family.parents[child] {
                    let detail = format!("nodes {other} and {node} both have it as a child");
                    let error = fault(child, "NODE_PARENT_OVERRIDE", detail);
                    faults.tolerate(&place(child), error, "it stays with the first")?;
                    continue;
                }
                family.parents[child] = Some(node);
                family.children[node].push(child);
            }
        }
        Ok(family)
    }

    /// With at most one parent each, a node that no root reaches is part of a loop, or hangs from one.
    fn find_loops(&self, mut reached: Vec<bool>, faults: &mut Faults) -> Result<(), SceneError> {
        for node in 0..reached.len() {
            if reached[node] {
                continue;
            }
            let error = fault(node, "NODE_LOOP", "it is its own ancestor, or below a node that is");
            faults.tolerate(&place(node), error, "it is left out with all above and below it")?;
            let mut stack = vec![node];
            while let Some(node) = stack.pop() {
                if !std::mem::replace(&mut reached[node], true) {
                    stack.extend(self.children[node].iter().copied().chain(self.parents[node]));
                }
            }
        }
        Ok(())
    }

    /// True where `accept` holds for a node above `node`; those of a loop must not be asked for.
    fn any_above(&self, node: usize, accept: impl Fn(usize) -> bool) -> bool {
        std::iter::successors(self.parents[node], |&above| self.parents[above]).any(accept)
    }
}

/// The nodes that have a place, are not hidden, and are below what the scene lists, each once.
fn shown(
    document: &Document,
    family: &Family,
    placed: &[bool],
    faults: &mut Faults,
) -> Result<Vec<usize>, SceneError> {
    let first = document.scenes.first();
    let scene = match document.scene {
        Some(index) => {
            let found = document.get(index, "scene");
            faults.or_without("scene", found, "the first scene is shown")?.or(first)
        }
        None => first,
    };
    let roots: Vec<usize> = match scene {
        None => (0..document.nodes.len()).filter(|&node| family.parents[node].is_none()).collect(),
        Some(scene) => listed_roots(document, scene, family, placed, faults)?,
    };
    let mut shown = Vec::new();
    let mut stack: Vec<usize> = roots.into_iter().rev().collect();
    while let Some(node) = stack.pop() {
        if placed[node] && is_visible(&document.nodes[node], node, faults)? {
            shown.push(node);
            stack.extend(family.children[node].iter().rev());
        }
    }
    Ok(shown)
}

/// False where `KHR_node_visibility` hides a node, with all below it.
fn is_visible(node: &json::Node, index: usize, faults: &mut Faults) -> Result<bool, SceneError> {
    let extensions = node.extensions.as_ref().map(|extensions| &extensions.others);
    let visibility = extension::<Visibility>(extensions, "KHR_node_visibility", &place(index));
    let visibility = faults.or_without(&place(index), visibility, "it is shown")?.flatten();
    Ok(visibility.is_none_or(|visibility| visibility.visible.unwrap_or(true)))
}

/// The nodes that a scene lists, without those that are shown with another of the list.
fn listed_roots(
    document: &Document,
    scene: &json::Scene,
    family: &Family,
    placed: &[bool],
    faults: &mut Faults,
) -> Result<Vec<usize>, SceneError> {
    let name = format!("scene {:?}", scene.name.as_deref().unwrap_or(""));
    let mut listed = vec![false; document.nodes.len()];
    let mut order = Vec::new();
    let mut below: Vec<usize> = Vec::new();
    for &root in &scene.nodes {
        let found = document.get(root, &name);
        if faults.or_without(&name, found, "that node is left out")?.is_none() {
            continue;
        }
        let root = root.value();
        if !placed[root] || std::mem::replace(&mut listed[root], true) {
            continue;
        }
        order.push(root);
        if family.parents[root].is_some() {
            below.push(root);
        }
    }
    if let Some(&first) = below.first() {
        let others = match below.len() - 1 {
            0 => String::new(),
            others => format!(", and so it is with {others} more"),
        };
        let detail = format!("a scene lists it, but it has a parent{others}");
        let error = fault(first, "SCENE_NON_ROOT_NODE", detail);
        faults.tolerate(&place(first), error, "it is shown once, where its parent puts it")?;
        order.retain(|&root| !family.any_above(root, |above| listed[above]));
    }
    Ok(order)
}

fn local_transform(node: &Transform, index: usize, faults: &mut Faults) -> Result<DAffine3, SceneError> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix);
        if matrix.row(3) != glam::DVec4::W {
            let error = fault(index, "NODE_MATRIX_NON_TRS", "the last row of its matrix is not 0 0 0 1");
            faults.tolerate(&place(index), error, "that row is left out")?;
        }
        let [x, y, z, w] = [0, 1, 2, 3].map(|column| matrix.col(column).truncate());
        return Ok(DAffine3::from_cols(x, y, z, w));
    }
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => {
            let rotation = quaternion(rotation)
                .ok_or_else(|| fault(index, "ROTATION_NON_UNIT", "its rotation has no length"));
            faults.or_without(&place(index), rotation, "it is not rotated")?.unwrap_or(DQuat::IDENTITY)
        }
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
pub fn instances(
    node: &json::Node,
    index: usize,
    accessors: &Accessors<'_>,
) -> Result<Vec<DAffine3>, SceneError> {
    let place = format!("nodes[{index}].extensions.EXT_mesh_gpu_instancing");
    let extensions = node.extensions.as_ref().map(|extensions| &extensions.others);
    let Some(Instancing { attributes }) =
        extension(extensions, "EXT_mesh_gpu_instancing", &format!("nodes[{index}]"))?
    else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let read = |what, kinds, integers| {
        let Some(&accessor) = attributes.get(what) else { return Ok(None) };
        accessors.read(accessor, &Format { what, kinds, integers, float: true }, &place).map(Some)
    };
    let translations = read("TRANSLATION", &[Type::Vec3], NO_NORMALIZED)?;
    let rotations = read("ROTATION", &[Type::Vec4], QUATERNIONS)?;
    let scales = read("SCALE", &[Type::Vec3], NO_NORMALIZED)?;
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
    SceneError::invalid(place(node), code, detail)
}

fn place(node: usize) -> String {
    format!("nodes[{node}]")
}
