#import bind/accel
#import bind/light_cache
#if subspaces
#import bind/buckets
#endif
#import bind/queue
#import lib/alias
#import lib/hit
#import lib/medium
#import lib/path_key
#import lib/strategies
#if learns
#import lib/training
#endif

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
fn select_light_vertex(index: u32, path: u32, depth: u32, number: u32) -> Selection {
#if subspaces
    // Two stages: a light subspace by Gamma, and of it a vertex in proportion to |w|. Where the subspace is empty
    // this time, there is no connection, and no other draw: that would be a bias.
    let eye_label = eye_labels[index].x;
    let words = random4(path_key(path), bounce_dimension(depth, DIMENSION_LIGHT));
    let mixed = pcg4d(vec4u(words.xyz, number));
    let draw = alias_draw(mixed.xy, batch.subspaces);
    let slot = gamma_alias[eye_label * batch.subspaces + draw.slot];
    let light_label = alias_pick(draw, slot.x, slot.y);
    let range = bucket_range(light_label);
    if range.x == range.y {
        return Selection(NO_VERTEX, 0.0);
    }
    let n = range.y - range.x;
    let item = bucket_items[draw_from_bucket(range, mixed.zw)];
    let table_units = n << slot_bits(n);
    let expected = f32(batch.light_path_count) * f32(CELLS) * gamma_pdf[eye_label * batch.subspaces + light_label];
    return Selection(item.x, f32(table_units) / f32(item.y) / expected);
#else
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
#endif
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
    let selection = select_light_vertex(index, ray.path, depth, counts.connection_round * CELLS + cell);
    if selection.vertex == NO_VERTEX {
        return;
    }
    let vertex = light_vertices[selection.vertex];
    let light_depth = vertex.depth_kind & 0xffffu;
    let kind = kind_of(vertex);
    let wanted = batch.only_s == EVERY_STRATEGY
        || (batch.only_s == light_depth + 1u && batch.only_t == depth + 2u);
    if depth + light_depth + 2u > batch.max_depth || !wanted || !any(vertex.weight != vec3f(0.0)) {
        return;
    }
    let arrival = arrive(eye_point, ray.direction, ray.pdf_solid, sub_paths_in[index]);
    let medium = medium_between(ray.depth_medium >> 16u, eye_point, arrival.world_from);
    let through = transmittance(medium, hit.t);
    var shares: EyeShares;
#if subspaces
    let share = shares_in[index];
    shares = EyeShares(vec4f(share.rgb * through, share.w), eye_labels[index]);
#endif
    let connection = connect(eye_point, arrival, shares, vertex);
    let link = connection.link;
    let weight = select(1.0, connection.weight, batch.weighted != 0u);
    let contribution = ray.throughput * through * connection.light * (weight * selection.inv_density);
    if !any(contribution != vec3f(0.0)) {
        return;
    }
    var shadow = shadow_ray(eye_point, link, kind);
    shadow.depth = depth;
#if learns
    // The path with the density of all ways to find it; whether its ends see each other goes to its cell.
    var end: TrainingEnd;
    end.emitted = vertex.weight / connection.density;
    end.path = ray.path;
    end.f = connection.f_eye * through;
    end.depth_sampled = depth | (1u << 16u);
    end.f_light = connection.f_light;
    end.vertex = light_path_offsets[vertex.path] + (vertex.number_label & 0xffffu);
    end.contribution = magnitude(ray.throughput * through * connection.light) / connection.density;
    end.geometry = connection.geometry;
    end.pdf_light = connection.pdf_light;
    end.pdf_back = connection.pdf_back;
    end.direction = link.direction;
    shadow.contribution = vec3f(1.0);
    shadow.cell = write_end(end);
    if shadow.cell >= arrayLength(&training_ends) {
        return;
    }
#else
    shadow.contribution = contribution;
    shadow.cell = ray.path * CELLS + cell;
#endif
    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = shadow;
}
