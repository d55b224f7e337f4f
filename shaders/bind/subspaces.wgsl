#import lib/tree

// What was learnt before rendering, and is fixed while an iteration runs: the classification of sub-paths, the subspace
// sampling matrix Gamma and the normaliser Q.

@group(3) @binding(4) var<storage, read> eye_tree: array<TreeNode>;
@group(3) @binding(5) var<storage, read> light_tree: array<TreeNode>;
/// Of each light: its first label, and how many cells it has along a side.
@group(3) @binding(6) var<storage, read> source_labels: array<vec2u>;
/// Probability of each light subspace (column) for each eye subspace (row), as the tables draw it.
@group(3) @binding(7) var<storage, read> gamma_pdf: array<f32>;
/// A table a row: words below the first number draw its column or one before it; the second is the first column that a word
/// of this slot may draw, where K slots share all words evenly.
@group(3) @binding(8) var<storage, read> gamma_cutpoints: array<vec2u>;
/// 1 / Q of each light subspace.
@group(3) @binding(9) var<storage, read> inv_q: array<f32>;

fn tree_node(tree: u32, index: u32) -> TreeNode {
    if tree == TREE_EYE {
        return eye_tree[index];
    }
    return light_tree[index];
}

/// Light subspace of a point on a light; `at` as `halfway::subspace::LightEnd` says.
fn source_label(light: u32, at: vec2f) -> u32 {
    let labels = source_labels[light];
    return labels.x + source_cell(labels.y, at);
}
