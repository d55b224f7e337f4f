#import bind/accel
#import bind/light_cache
#import bind/queue
#import lib/alias
#import lib/emission
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/subpath

// Connects the vertices that eye paths have just reached to vertices of the light cache, one invocation for each
// connection. Which light vertex it is, is all that sets the bidirectional integrators apart.

/// A light vertex, and the inverse of the expected number of times that this iteration's connections of one eye
/// vertex choose it, over light paths: what a sum over the cache is multiplied with.
struct Selection {
    vertex: u32,
    inv_density: f32,
}

const NO_VERTEX: u32 = 0xffffffffu;

/// `number`: of the connection among those of the eye vertex.
fn select_light_vertex(path: u32, depth: u32, number: u32) -> Selection {
#if own_light_path
    // Every vertex of the light path that was traced for this eye path, once.
    let first = light_path_offsets[path];
    if first + number >= light_path_offsets[path + 1u] {
        return Selection(NO_VERTEX, 0.0);
    }
    return Selection(light_order[first + number], 1.0);
#else
    // Any vertex of the cache, all alike.
    let vertices = light_path_offsets[batch.light_path_count];
    let words = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    let draw = alias_draw(pcg4d(vec4u(words.xyz, number)).xy, vertices);
    let inv_density = f32(vertices) / (f32(batch.light_path_count) * f32(CELLS));
    return Selection(light_order[draw.slot], inv_density);
#endif
}

/// The edge between an eye vertex and a light vertex.
struct Link {
    /// Unit direction to the light vertex.
    direction: vec3f,
    /// MAX_FLOAT to infinity.
    distance: f32,
    /// Turn a density per solid angle at one end into the density at the other: per area, but per solid angle at an
    /// infinitely far light, and per area across the direction from there.
    to_light: f32,
    to_eye: f32,
    /// The point at the far end, where it is a surface.
    light_point: SurfacePoint,
}

/// Light from the vertex towards `direction`, as a share of its `weight`, and the density of that direction.
fn emitted(vertex: LightVertex, kind: u32, point: SurfacePoint, direction: vec3f) -> vec2f {
    switch kind {
#if area_lights
        case LIGHT_TRIANGLE + 1u: {
            let pdf_solid = emission_pdf_solid(point, direction);
            return vec2f(select(0.0, 1.0, pdf_solid > 0.0), pdf_solid);
        }
#endif
#if punctual_lights
        case LIGHT_POINT + 1u, LIGHT_SPOT + 1u: {
            let light = punctual_lights[vertex.index];
            let is_spot = kind == LIGHT_SPOT + 1u;
            let falloff = emission_falloff(light, direction, is_spot);
            return vec2f(falloff, uniform_cone_pdf_solid(emission_cone(light, is_spot)));
        }
#endif
        default: {
            return vec2f(1.0, disk_pdf_area());
        }
    }
}

fn link_to(point: SurfacePoint, vertex: LightVertex, kind: u32) -> Link {
    var link: Link;
    if kind == LIGHT_ENVIRONMENT + 1u || kind == LIGHT_DIRECTIONAL + 1u {
        link.direction = vertex.world_from;
        link.distance = MAX_FLOAT;
        link.to_light = 1.0;
        link.to_eye = abs(dot(link.direction, point.world_ng));
        return link;
    }
    var position: vec3f;
    var is_surface = true;
#if punctual_lights
    if kind > LIGHT_TRIANGLE + 1u {
        position = punctual_lights[vertex.index].position;
        is_surface = false;
    }
#endif
    if is_surface {
        link.light_point = surface_point(vertex.index, vertex.b1, vertex.b2);
        position = link.light_point.position;
    }
    let span = position - point.position;
    let distance_sq = dot(span, span);
    if distance_sq > 0.0 {
        link.distance = sqrt(distance_sq);
        link.direction = span / link.distance;
        let cos_light = select(1.0, abs(dot(link.direction, link.light_point.world_ng)), is_surface);
        link.to_light = cos_light / distance_sq;
        link.to_eye = abs(dot(link.direction, point.world_ng)) / distance_sq;
    }
    return link;
}

/// The ray that tests a link.
fn shadow_ray(point: SurfacePoint, link: Link, kind: u32) -> ShadowRay {
    let origin = ray_origin(point, link.direction);
    if link.distance == MAX_FLOAT {
        return ShadowRay(origin, 0u, link.direction, MAX_FLOAT, vec3f(0.0), 0u);
    }
    var end = point.position + link.direction * link.distance;
    if kind <= LIGHT_TRIANGLE + 1u {
        end = ray_origin(link.light_point, -link.direction);
    }
    return ShadowRay(origin, 0u, end - origin, 1.0 - 0x1p-20, vec3f(0.0), 0u);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let task = invocation(id);
    let index = task / CELLS;
    let cell = task % CELLS;
    if index >= counts.paths_in {
        return;
    }
    let ray = paths_in[index];
    let hit = hits[index];
    let depth = ray.depth_medium & 0xffffu;
    if hit.triangle == NO_TRIANGLE || depth + 2u > batch.max_depth {
        return;
    }
    let eye_point = surface_point(hit.triangle, hit.b1, hit.b2);
    if (materials[eye_point.material].flags & (MATERIAL_DELTA | MATERIAL_UNLIT)) != 0u {
        return;
    }
    let selection = select_light_vertex(ray.path, depth, counts.connection_round * CELLS + cell);
    if selection.vertex == NO_VERTEX {
        return;
    }
    let vertex = light_vertices[selection.vertex];
    let light_depth = vertex.depth_kind & 0xffffu;
    let kind = vertex.depth_kind >> 16u;
    let wanted = batch.only_s == EVERY_STRATEGY
        || (batch.only_s == light_depth + 1u && batch.only_t == depth + 2u);
    if depth + light_depth + 2u > batch.max_depth || !wanted || !any(vertex.weight != vec3f(0.0)) {
        return;
    }
    let link = link_to(eye_point, vertex, kind);
    if link.to_light == 0.0 {
        return;
    }
    let arrival = arrive(eye_point, ray.direction, ray.pdf_solid, sub_paths_in[index]);
    // The light's end: emission here, scattering below.
    var light = vertex.weight;
    var light_step = vertex.ratio / vertex.pdf_area;
    var pdf_eye = 0.0;
    if kind != 0u {
        let emission = emitted(vertex, kind, link.light_point, -link.direction);
        light *= emission.x;
        pdf_eye = emission.y * link.to_eye;
    }
    var pdf_light = 0.0;
    var eye_step = 0.0;
    // First the eye's end, then the light's: one call site for the whole BSDF.
    for (var turn = 0u; turn < select(1u, 2u, kind == 0u) && any(light > vec3f(0.0)); turn++) {
        let at_eye = turn == 0u;
        var point = link.light_point;
        var world_from = vertex.world_from;
        var world_to = -link.direction;
        if at_eye {
            point = eye_point;
            world_from = arrival.world_from;
            world_to = link.direction;
        }
        let surface = point_surface(point);
        let value = shading_evaluate(surface, point_frame(point), world_from, world_to, at_eye);
        let survives = survival(surface);
        light *= value.f;
        if at_eye {
            pdf_light = value.pdf_solid * survives * link.to_light;
            eye_step = arrival_step(arrival, value.pdf_back_solid * survives, false);
        } else {
            pdf_eye = value.pdf_solid * survives * link.to_eye;
            let pdf_back = value.pdf_back_solid * survives * vertex.to_previous;
            light_step = mis_step(vertex.ratio, pdf_back, vertex.edge, vertex.pdf_area);
        }
    }
    var weight = 1.0;
    if batch.weighted != 0u {
        weight = connection_weight(batch.connection_density, eye_step, pdf_eye, light_step, pdf_light);
    }
    let medium = medium_between(ray.depth_medium >> 16u, eye_point, arrival.world_from);
    var medium_across = medium_towards(eye_point, link.direction);
    if kind == 0u {
        medium_across = medium_between(medium_across, link.light_point, -link.direction);
    }
    let through = transmittance(medium, hit.t) * transmittance(medium_across, link.distance);
    let geometry = abs(dot(link.direction, eye_point.world_ng)) * link.to_light;
    let contribution = ray.throughput * through * light * (geometry * weight * selection.inv_density);
    if !any(contribution != vec3f(0.0)) {
        return;
    }
    var shadow = shadow_ray(eye_point, link, kind);
    shadow.cell = ray.path * CELLS + cell;
    shadow.contribution = contribution;
    shadow.depth = depth;
    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = shadow;
}
