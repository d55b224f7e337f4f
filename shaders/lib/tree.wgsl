// The classification of sub-paths by their last vertex: walks through the trees that `halfway::subspace` grows. The
// importing kernel brings `tree_node(tree, index)` (bind/subspaces).

struct TreeNode {
    /// Inner nodes: coordinates at or above it lie in the upper half.
    split: vec3f,
    /// A leaf's label, or the first of eight children with what they are told apart by: TREE_*.
    child_kind: u32,
}

/// Kind in the upper two bits, child or label in the others.
const TREE_KIND: u32 = 0xc0000000u;
const TREE_CHILD: u32 = 0x3fffffffu;
const TREE_LEAF: u32 = 0u;
const TREE_POSITION: u32 = 0x40000000u;
const TREE_NORMAL: u32 = 0x80000000u;
const TREE_DIRECTION: u32 = 0xc0000000u;

/// Which tree.
const TREE_EYE: u32 = 0u;
const TREE_LIGHT: u32 = 1u;

/// Label of a vertex. `normal` (unit) faces the incoming ray, `direction` (unit) points to the previous vertex.
fn tree_label(tree: u32, position: vec3f, normal: vec3f, direction: vec3f) -> u32 {
    var node = tree_node(tree, 0u);
    // It ends, since children are stored after their parents. A constant that bounds it would make drivers unroll it.
    while (node.child_kind & TREE_KIND) != TREE_LEAF {
        let kind = node.child_kind & TREE_KIND;
        let at = select(select(direction, normal, kind == TREE_NORMAL), position, kind == TREE_POSITION);
        let octant = select(vec3u(0u), vec3u(1u, 2u, 4u), at >= node.split);
        node = tree_node(tree, (node.child_kind & TREE_CHILD) + octant.x + octant.y + octant.z);
    }
    return node.child_kind & TREE_CHILD;
}

/// Cell of a point on a light that has `divisions` x `divisions` of them.
fn source_cell(divisions: u32, at: vec2f) -> u32 {
    let cell = min(vec2u(at * f32(divisions)), vec2u(divisions - 1u));
    return cell.x * divisions + cell.y;
}
