#import bind/batch
#import bind/queue
#import bind/subspaces
#import lib/hit

// The classification of vertices into subspaces, and what was learnt of pairs of them. Su, Li, Wang 2022.

/// What a surface's vertices are classified by as its normal: the side that the ray came from, but one side for both
/// where light passes through, since a vertex must have one label whichever way it is looked at.
fn label_normal(point: SurfacePoint, world_from: vec3f) -> vec3f {
#if transmission
    if materials[point.material].transmission > 0.0 {
        return point.world_ng;
    }
#endif
    return select(-point.world_ng, point.world_ng, dot(world_from, point.world_ng) > 0.0);
}

/// Subspace of a surface vertex in one of the trees.
fn vertex_label(tree: u32, point: SurfacePoint, world_from: vec3f) -> u32 {
    return tree_label(tree, point.position, label_normal(point, world_from), world_from);
}

/// Gamma / Q: the density of a connection by subspaces over |w| of its light vertex and the scale of its eye vertex.
fn gamma_over_q(eye_label: u32, light_label: u32) -> f32 {
    return gamma_pdf[eye_label * batch.subspaces + light_label] * inv_q[light_label];
}
