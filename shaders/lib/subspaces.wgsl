#import bind/batch
#import bind/queue
#import bind/subpath
#import bind/subspaces
#import lib/color
#import lib/hit

// Connections by subspaces: an eye vertex z of eye subspace e is connected to a light vertex y of light subspace l
// with density Gamma[e][l] |w_y| / Q[l] over that of its light sub-path, N times. In the terms of lib/mis
//
//   c(z, y) = N Gamma[e][l] |w_y| / Q[l]
//
// depends on the whole light sub-path through w, so that the eye's side has to remember a colour in place of a ratio:
//
//   A(z_k) = (A(z_{k-1}) f(z_{k-1}) G(z_{k-1}, z_{k-2}) + N Gamma / Q (z_{k-2}, z_{k-1})) / pE(z_{k-1})
//
// and the densities of all connections nearer to the eye than (z, y) are |w_y f(y) G(y, z) A|, continued to z.
// Su, Li, Wang 2022.

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

/// N Gamma / Q.
fn connection_share(eye_label: u32, light_label: u32) -> f32 {
    return f32(CELLS) * gamma_pdf[eye_label * batch.subspaces + light_label] * inv_q[light_label];
}

/// c between a light path's vertex, if it is no delta vertex, and the one before it, which has |w| / Q of `share` and the
/// light subspace `column`. `world_to`: to the vertex that is nearer to the camera.
fn light_edge(point: SurfacePoint, world_to: vec3f, share: f32, column: u32) -> f32 {
    if share == 0.0 {
        return 0.0;
    }
    let row = vertex_label(TREE_EYE, point, world_to);
    return f32(CELLS) * gamma_pdf[row * batch.subspaces + column] * share;
}

/// Light subspace of an eye path's vertex to which light comes from `world_to`. `known`: what it is where directions do
/// not matter.
fn eye_light_label(point: SurfacePoint, world_to: vec3f, known: u32) -> u32 {
#if subspace_directions
    return vertex_label(TREE_LIGHT, point, world_to);
#else
    return known;
#endif
}

/// N Gamma / Q between an eye path's vertex, if it is no delta vertex, and the one before it.
fn eye_share(flags: u32, share: vec4f, light_label: u32) -> f32 {
    if (flags & (SUBPATH_DELTA | SUBPATH_CAMERA)) != 0u {
        return 0.0;
    }
    return connection_share(bitcast<u32>(share.w), light_label);
}

/// `share` of the ray that leaves a light path's vertex: 0 for a delta vertex.
fn light_share(weight: vec3f, label: u32) -> vec4f {
    return vec4f(magnitude(weight) * inv_q[label], 0.0, 0.0, bitcast<f32>(label));
}
