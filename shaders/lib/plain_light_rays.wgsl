#import bind/light_cache
#if at_records
#import bind/light_ends
#endif
#import bind/subpath

// For weights to which rays of light paths bring no more than `SubPath`, and vertices of the cache no more than their edge:
// what lib/weights_subspaces carries beside these is nothing here.

#if at_records
/// Of a ray that has reached a vertex: density of connecting that, with the scale of DEEP, to the vertex before.
alias LightMis = f32;

fn load_light_mis(index: u32) -> LightMis {
    return light_edges[index];
}

/// The ray leaves the vertex that was put into the cache last, unless it leaves a delta vertex.
fn store_light_mis(slot: u32, mis: LightMis) {
    light_ends_out[slot] = cached_slot;
}
#else
/// Of a ray that leaves a light vertex: nothing.
alias LightMis = u32;

fn load_light_mis(index: u32) -> LightMis {
    return 0u;
}

fn store_light_mis(slot: u32, mis: LightMis) {}
#endif

fn light_subspace(point: SurfacePoint, world_from: vec3f) -> u32 {
    return 0u;
}

fn add_edge_of_bounce(
    bounce: ptr<function, Bounce>, point: SurfacePoint, vertex: PathVertex, mis: LightMis, is_delta: bool,
) -> f32 {
    return 0.0;
}

fn cached_with_edge(vertex: LightVertex, mis: LightMis) -> LightVertex {
    return vertex;
}

#if !lambert_vertices
/// c of lib/mis between a vertex of the cache and the one before it, seen from `world_to`, with the scale of DEEP.
fn cached_edge(vertex: LightVertex, point: SurfacePoint, world_to: vec3f) -> f32 {
    return vertex.edge;
}
#endif

fn light_mis_of_bounce(throughput: vec3f, behind: f32, is_delta: bool, label: u32, nominal: f32) -> LightMis {
    return LightMis();
}

/// Second vertices have the scale of all that are deeper: `Plan::density_scales`.
fn edge_before(mis: LightMis) -> f32 {
    return 0.0;
}

fn nominal_of(mis: LightMis) -> f32 {
    return 1.0;
}
