// Walks a path from both ends, as the kernels do but along given directions, and notes the weight of each strategy.

#import bind/accel
#import lib/connections
#import lib/light_vertex
#import lib/medium
#if at_records
#import lib/record_edge
#endif
#import lib/strategies

struct Frozen {
    direction: vec3f,
    /// Number of edges.
    n: u32,
    /// LIGHT_* and index into `lights`.
    kind: u32,
    light: u32,
    pad0: u32,
    pad1: u32,
    vertices: array<vec4u, 8>,
}

@group(2) @binding(10) var<storage, read> frozen: array<Frozen>;
@group(2) @binding(11) var<storage, read_write> weights: array<f32>;
/// Position and geometric normal of each vertex, as the kernels have them: what they are classified by.
@group(2) @binding(12) var<storage, read_write> points: array<vec4f>;
#if at_records
/// Of each connection the part of each of its choices, by the eye vertex.
@group(2) @binding(13) var<storage, read_write> choices: array<vec4f>;
#endif

/// How much denser light paths are at x_i than unguided ones, for this choice alone: from a fifth to five times.
fn guided_by(path: u32, i: u32) -> f32 {
#if nominal
    return exp2(4.6 * fract(0.6180339887 * f32(path % 4096u) + 0.7548776662 * f32(i)) - 2.3);
#else
    return 1.0;
#endif
}

fn point_at(path: u32, i: u32) -> SurfacePoint {
    let vertex = frozen[path].vertices[i - 1u];
    return surface_point(vertex.x, bitcast<f32>(vertex.y), bitcast<f32>(vertex.z));
}

/// Unit direction from x_i to x_{i+1}.
fn direction_from(path: u32, i: u32) -> vec3f {
    let at_end = i + 1u == frozen[path].n;
    if at_end && frozen[path].kind != LIGHT_TRIANGLE {
#if punctual_lights
        if frozen[path].kind == LIGHT_POINT || frozen[path].kind == LIGHT_SPOT {
            let light = punctual_lights[lights[frozen[path].light].index];
            return normalize(light.position - point_at(path, i).position);
        }
#endif
        return frozen[path].direction;
    }
    return normalize(point_at(path, i + 1u).position - point_at(path, i).position);
}

/// The same, of a vertex at `depth`.
fn at_depth(partials: EyePartials, depth: u32) -> EyePartials {
#if subspaces
    return EyePartials(partials.mis, partials.labels, depth);
#else
#if at_records
    return EyePartials(
        partials.link, depth, vec3f(1.0), partials.records, partials.reach, vec3f(0.0), CHOICE_ALL,
    );
#else
#if resampling
    return EyePartials(partials.link, depth, vec3f(1.0), partials.inv_q);
#else
    return depth;
#endif
#endif
#endif
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let path = id.x;
    if path >= arrayLength(&frozen) {
        return;
    }
    let n = frozen[path].n;
    let kind = frozen[path].kind;
    let light = frozen[path].light;
    let first = path * 10u - 1u;

    // From the light: vertices x_n .. x_1.
    var light_side: array<LightVertex, 9>;
    var nominals: array<f32, 9>;
#if at_records
    // Of x_{i+1}, at the records of x_i.
    var brought: array<vec3f, 9>;
    var reaches: array<vec3f, 9>;
#endif
    let infinite = kind == LIGHT_ENVIRONMENT || kind == LIGHT_DIRECTIONAL;
    let is_triangle = kind == LIGHT_TRIANGLE;
    let ratio = select(0.0, batch.hit_scale, is_triangle || kind == LIGHT_ENVIRONMENT);
    let towards_light = direction_from(path, n - 1u);
    var position: vec3f;
    var normal: vec3f;
    var pdf_light = lights[light].pdf_select;
    var pdf_solid = disk_pdf_area();
    // The light's vertex: radiance, intensity or irradiance over its density, and what a ray from there carries.
    var emitted = vec3f(0.0);
    var carried = 1.0;
    var at = vec2f(0.0);
#if area_lights
    if is_triangle {
        let point = point_at(path, n);
        position = point.position;
        normal = point.world_ng;
        pdf_light /= point.area;
        pdf_solid = emission_pdf_solid(point, -towards_light);
        at = point.b.yz;
        emitted = point_emission(point, -towards_light) * point_presence(point);
        carried = PI * emitting_sides(point);
        points[path * 16u + 2u * (n - 1u)] = vec4f(point.position, 0.0);
        points[path * 16u + 2u * (n - 1u) + 1u] = vec4f(point.world_ng, 0.0);
    }
#endif
#if environment
    if kind == LIGHT_ENVIRONMENT {
        pdf_light = environment_pdf_solid(towards_light);
        emitted = environment_radiance(towards_light);
        carried = 1.0 / disk_pdf_area();
        at = sphere_to_square(towards_light);
    }
#endif
#if punctual_lights
    if kind > LIGHT_ENVIRONMENT {
        emitted = punctual_lights[lights[light].index].intensity;
        carried = 1.0 / disk_pdf_area();
    }
    if kind == LIGHT_POINT || kind == LIGHT_SPOT {
        let punctual = punctual_lights[lights[light].index];
        position = punctual.position;
        pdf_solid = uniform_cone_pdf_solid(punctual.cone);
        carried = emission_falloff(punctual, -towards_light, kind == LIGHT_SPOT) / pdf_solid;
    }
#endif
    // The light itself is picked so much more often, and its ray goes so much more often where it goes.
    pdf_light *= guided_by(path, n);
    pdf_solid *= guided_by(path, n - 1u);
    nominals[n] = 1.0 / guided_by(path, n);
    let weight = emitted / pdf_light;
    var throughput = weight * (carried / guided_by(path, n - 1u));
    let index = select(lights[light].index, frozen[path].vertices[n - 1u].x, is_triangle);
    var label = 0u;
#if subspaces
    label = source_label(light, at);
#endif
    var mis = light_mis_of_bounce(weight, 0.0, false, label, nominals[n] / guided_by(path, n - 1u));
    let place = vec2u(0u, label << 16u);
    light_side[n] = source_vertex(kind, index, at, towards_light, weight, pdf_light, ratio, place);
    var medium = 0u;
    var previous = SubPath(position, ratio / pdf_light, normal, select(0u, SUBPATH_INFINITE, infinite));
    var direction = -towards_light;
    for (var i = n - 1u; i >= 1u; i--) {
        let point = point_at(path, i);
        points[path * 16u + 2u * (i - 1u)] = vec4f(point.position, 0.0);
        points[path * 16u + 2u * (i - 1u) + 1u] = vec4f(point.world_ng, 0.0);
        var vertex = turned_vertex(point, direction, pdf_solid, previous, light_scale(point));
        let crossed = select(distance(point.position, previous.position), 0.0, infinite && i == n - 1u);
        throughput *= transmittance(medium_between(medium, point, vertex.world_from), crossed);
        // Before x_1 the camera, which only t = 1 sees.
        var to_camera = camera_view(point.position).direction;
        if i > 1u {
            to_camera = -direction_from(path, i - 1u);
        }
#if at_records
        let near = nearest_records(point.position);
        brought[i] = light_at_records(near, light_side[i + 1u]);
        mis = select(record_edge(point, near, brought[i]), 0.0, (previous.flags & SUBPATH_DELTA) != 0u);
        var seen_vertex = vertex_towards(towards_light);
        if i + 1u < n || is_triangle {
            let corner = frozen[path].vertices[i];
            seen_vertex = vertex_at(corner.x, vec2f(bitcast<f32>(corner.y), bitcast<f32>(corner.z)));
        }
        reaches[i + 1u] = record_reach(near, seen_vertex);
#endif
        vertex.edge = edge_towards(point, vertex, mis, to_camera, throughput);
        label = light_subspace(point, vertex.world_from);
        let surface = point_surface(point);
        let cached = surface_vertex(point, surface, vertex, throughput, n - i, vec2u(0u, label << 16u));
        light_side[i] = cached_with_edge(cached, mis);
        nominals[i] = nominal_of(mis);
        if i == 1u {
            if batch.camera_paths > 0.0 && !is_delta(point) {
                let seen = seen_by_camera(vertex, mis);
                weights[first + 1u] = connect_camera(point, seen, camera_view(point.position), nominals[i]).weight;
            }
        } else {
            direction = -direction_from(path, i - 1u);
            let step = step_along(point, vertex, direction, false);
            // No guide draws a mirror's direction.
            let guided = select(guided_by(path, i - 1u), 1.0, is_delta(point));
            pdf_solid = step.pdf_solid * guided;
            previous = step.next;
            medium = medium_towards(point, direction);
            let behind = select(vertex.edge / vertex.pdf_area, 0.0, is_delta(point));
            mis = light_mis_of_bounce(throughput, behind, is_delta(point), label, nominal_of(mis) / guided);
            throughput *= step.weight / guided;
        }
    }

    // From the eye: vertices x_1 .. x_n.
    direction = normalize(point_at(path, 1u).position - camera.origin);
    if n == 1u && !is_triangle {
        direction = frozen[path].direction;
    }
    pdf_solid = camera_pdf(direction);
    previous = SubPath(camera.origin, 0.0, vec3f(0.0), SUBPATH_CAMERA);
    var partials: EyePartials;
#if resampling
    partials.link = NO_LINK;
#endif
    var medium_before = 0u;
    for (var i = 1u; i < n; i++) {
        let point = point_at(path, i);
        partials = at_depth(partials, i - 1u);
        let vertex = turned_vertex(point, direction, pdf_solid, previous, eye_scale(i - 1u, previous));
        let medium_here = medium_between(medium_before, point, vertex.world_from);
        let through = transmittance(medium_here, distance(point.position, previous.position));
        partials = absorb(partials, through);
        medium_before = medium_towards(point, direction_from(path, i));
#if subspaces
        let world_from = vertex.world_from;
        partials.labels =
            vec2u(vertex_label(TREE_EYE, point, world_from), vertex_label(TREE_LIGHT, point, world_from));
#endif
#if at_records
        partials.records = nearest_records(point.position);
        partials.reach = reaches[i];
#else
#if resampling
        partials.inv_q = inv_q_of(nearest_records(point.position));
#endif
#endif
        if !is_delta(point) {
            var connects = true;
            if i + 1u < n {
                connects = !is_delta(point_at(path, i + 1u));
            }
            if connects {
                let seen = seen_unguided(vertex, nominals[i + 1u]);
#if at_records
                var each = vec4f(0.0);
                // Drivers unroll a loop whose length is a constant.
                for (var choice = 0u; choice < select(CHOICES, 0u, n == 0u); choice++) {
                    let chosen = with_choice(partials, brought[i], choice);
                    each[choice] = connect(eye_end(point, seen), chosen, light_side[i + 1u]).weight;
                }
                choices[path * 8u + i] = each;
                weights[first + i + 1u] = sum_of(each);
#else
                weights[first + i + 1u] = connect(eye_end(point, seen), partials, light_side[i + 1u]).weight;
#endif
            }
        }
        direction = direction_from(path, i);
        let step = step_along(point, vertex, direction, true);
#if subspaces
        let f = step.weight * (step.pdf_solid / abs(dot(direction, point.world_ng)));
        partials.mis = eye_mis_of_bounce(point, vertex, partials, direction, f, 0.0, is_delta(point));
#endif
#if resampling
        let f = step.weight * (step.pdf_solid / abs(dot(direction, point.world_ng)));
        let back = step.pdf_back_solid * vertex.to_previous;
        partials.link = eye_mis_of_bounce(point, vertex, partials, direction, f, back, is_delta(point));
#endif
        pdf_solid = step.pdf_solid;
        previous = step.next;
    }
    partials = at_depth(partials, n - 1u);
#if at_records
    partials.reach = reaches[n];
#endif
#if area_lights
    if is_triangle {
        let point = point_at(path, n);
        let vertex = turned_vertex(point, direction, pdf_solid, previous, eye_scale(n - 1u, previous));
        let medium_here = medium_between(medium_before, point, vertex.world_from);
        let through = transmittance(medium_here, distance(point.position, previous.position));
        partials = absorb(partials, through);
        weights[first + n + 1u] = emitter_weight(point, vertex, partials, light);
    }
#endif
#if environment
    if kind == LIGHT_ENVIRONMENT {
        weights[first + n + 1u] = environment_weight(previous, partials, direction, pdf_solid);
    }
#endif
}
