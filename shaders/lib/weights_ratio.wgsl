#import bind/batch
#import bind/light_cache
#import bind/subpath
#import lib/connections
#import lib/emission
#import lib/light
#import lib/mis
#import lib/plain_light_rays
#import lib/subpath
#import lib/thinning

// Weights where the density of a connection is the same for all pairs of vertices: `SubPath` carries all that is needed,
// and what lib/weights_subspaces carries beside it is nothing here.

/// Of a ray that leaves an eye vertex: nothing.
alias EyeMis = u32;
/// Of an eye vertex: its depth.
alias EyePartials = u32;

fn load_eye_partials(index: u32, depth: u32) -> EyePartials {
    return depth;
}

fn absorb(partials: EyePartials, through: vec3f) -> EyePartials {
    return partials;
}

fn eye_mis_of_bounce(
    point: SurfacePoint, vertex: PathVertex, partials: EyePartials, direction: vec3f, f: vec3f, pdf_back: f32,
    is_delta: bool,
) -> EyeMis {
    return 0u;
}

fn store_eye_mis(slot: u32, mis: EyeMis) {}

fn edge_so_far(point: SurfacePoint, vertex: PathVertex, mis: LightMis, throughput: vec3f) -> f32 {
    return vertex.edge;
}

fn edge_towards(
    point: SurfacePoint, vertex: PathVertex, mis: LightMis, world_to: vec3f, throughput: vec3f,
) -> f32 {
    return vertex.edge;
}

fn eye_depth(partials: EyePartials) -> u32 {
    return partials;
}

/// The weight of a connection, and the density of all strategies that make the path, over those of its two sub-paths.
/// Each side: its `mis_step`, and the density of its vertex as sampled from the other end.
fn weigh_connection(
    eye_point: SurfacePoint, eye_vertex: PathVertex, partials: EyePartials, light_vertex: LightVertex, direction: vec3f,
    f_eye: vec3f, arriving_light: vec3f, eye_step: f32, pdf_back: f32, pdf_eye: f32, light_step: f32, pdf_light: f32,
) -> ConnectionWeight {
    let edge = density_scale(partials) * thinning_at(eye_point.material);
    let density = edge + eye_step * pdf_eye + light_step * pdf_light;
    return ConnectionWeight(edge / density, density);
}

#if area_lights
/// Weight of an eye path that met an emitting triangle; `light`: its index in `lights`.
fn emitter_weight(point: SurfacePoint, vertex: PathVertex, partials: EyePartials, light: u32) -> f32 {
    if (vertex.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = emission_pdf_solid(point, vertex.world_from) * vertex.to_previous;
    let pdf_light = lights[light].pdf_select / point.area;
    return hit_weight(batch.hit_scale, vertex.edge, vertex.ratio, pdf_previous, pdf_light, vertex.pdf_area);
}
#endif

#if environment
/// Weight of an eye path that left the scene along `direction`, which has the density `pdf_solid`.
fn environment_weight(previous: SubPath, partials: EyePartials, direction: vec3f, pdf_solid: f32) -> f32 {
    if (previous.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = abs(dot(direction, previous.normal)) * disk_pdf_area();
    let pdf_light = environment_pdf_solid(direction);
    let scale = density_scale(partials - 1u) * thinning_before(previous.flags);
    let edge = edge_density(previous.flags, scale);
    return hit_weight(batch.hit_scale, edge, previous.ratio, pdf_previous, pdf_light, pdf_solid);
}
#endif
