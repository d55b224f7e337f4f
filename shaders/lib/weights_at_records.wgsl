#import bind/batch
#import bind/eye_links
#import bind/eye_records
#import bind/light_cache
#import bind/queue
#import bind/records
#import bind/subpath
#import lib/color
#import lib/connections
#import lib/emission
#import lib/light
#import lib/mis
#import lib/plain_light_rays
#import lib/record_shares
#import lib/subpath
#import lib/thinning

// Weights that know of the resampling by records one at a time (lib/record_shares): a connection of z and y is worth S times
// the sum of v_k, and the one that was drawn by choice k counts S v_k of it; S is the scale of z's depth times its thinning.
//
// v_k depends on the light r_k that y brings to the k-th of the records nearest to z, by way of y's BSDF, and on whether the
// record sees y:
//
// * For the connection itself r_k is what the record's table has.
// * Where y belongs to the eye path, which a ray of the queue has just reached, eye_reach asks the records of the vertex
//   before: three rays. The BSDF waits for the direction that light comes from, that is the path's next.
// * Where z belongs to the light path, light_edges has three rays as well, and all the rest.
//
// v_k is not linear in |w|, so that no sum for all vertices before is enough: the eye's side has a list of its vertices,
// the last one first (`eye_links`), and goes along it.

/// Of a ray that leaves an eye vertex: its place in `eye_links`.
alias EyeMis = u32;

/// What weights need of an eye vertex.
struct EyePartials {
    /// The list of those before.
    link: u32,
    depth: u32,
    /// What the last segment lets pass.
    through: vec3f,
    /// Nearest to it.
    records: vec3u,
    /// Geometry to the records of the vertex before.
    reach: vec3f,
    /// Of a connection: r of its light vertex at `records`, and the choice that it was drawn by.
    light: vec3f,
    choice: u32,
}

/// Of the vertex that a ray of the queue has just reached.
fn load_eye_partials(index: u32, depth: u32) -> EyePartials {
    return EyePartials(
        eye_ends_in[index], depth, vec3f(1.0), eye_records[index].xyz, eye_reach[index].xyz, vec3f(0.0), CHOICE_ALL,
    );
}

/// Of an eye vertex that is connected to a light vertex.
fn with_choice(partials: EyePartials, light: vec3f, choice: u32) -> EyePartials {
    var chosen = partials;
    chosen.light = light;
    chosen.choice = choice;
    return chosen;
}

/// The weight of a connection where all of its kind are taken alone: the share of its choice.
fn weight_alone(partials: EyePartials) -> f32 {
    let densities = choice_densities(partials.light, partials.records);
    return densities[partials.choice] / sum_of(densities);
}

fn absorb(partials: EyePartials, through: vec3f) -> EyePartials {
    var absorbed = partials;
    absorbed.through *= through;
    return absorbed;
}

fn eye_depth(partials: EyePartials) -> u32 {
    return partials.depth;
}

/// For each record of the vertex before: what goes to it of light that arrives at an eye vertex from `world_light`.
fn reach_of(point: SurfacePoint, partials: EyePartials, world_light: vec3f) -> mat3x3f {
    var reach = mat3x3f();
    if partials.link == NO_LINK || all(partials.reach == vec3f(0.0)) {
        return reach;
    }
    let surface = point_surface(point);
    let frame = point_frame(point);
    let before = eye_links[partials.link].records;
    for (var k = 0u; k < records_among(before); k++) {
        if partials.reach[k] > 0.0 {
            let world_to = normalize(records[before[k]].position - point.position);
            reach[k] = partials.reach[k] * shading_evaluate(surface, frame, world_light, world_to, false).f;
        }
    }
    return reach;
}

/// Puts an eye vertex into its path's list when its ray goes on along `direction`, for which the BSDF is `f`; `pdf_back`:
/// density per area of the vertex before, as sampled from here.
fn eye_mis_of_bounce(
    point: SurfacePoint, vertex: PathVertex, partials: EyePartials, direction: vec3f, f: vec3f, pdf_back: f32,
    is_delta: bool,
) -> EyeMis {
    let slot = atomicAdd(&eye_link_count, 1u);
    if slot >= arrayLength(&eye_links) {
        return NO_LINK;
    }
    let scale = density_scale(partials.depth) * thinning_at(point.material);
    var reach = mat3x3f();
    if !is_delta {
        reach = reach_of(point, partials, direction);
    }
    eye_links[slot] = RecordLink(
        f * step_to_before(point, vertex, partials),
        partials.link,
        reach[0],
        pdf_back,
        reach[1],
        vertex.pdf_area,
        reach[2],
        select(scale, 0.0, is_delta),
        partials.records,
        0u,
    );
    return slot;
}

/// Of what leaves an eye vertex to the vertex before, what arrives there.
fn step_to_before(point: SurfacePoint, vertex: PathVertex, partials: EyePartials) -> vec3f {
    return partials.through * (abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous);
}

/// Of the ray in a slot of the queue.
fn store_eye_mis(slot: u32, mis: EyeMis) {
    eye_ends_out[slot] = mis;
}

fn edge_so_far(point: SurfacePoint, vertex: PathVertex, mis: LightMis, throughput: vec3f) -> f32 {
    return mis;
}

fn edge_towards(
    point: SurfacePoint, vertex: PathVertex, mis: LightMis, world_to: vec3f, throughput: vec3f,
) -> f32 {
    return mis;
}

/// The end of a light path at a vertex x, of which an eye path knows the vertices before.
struct LightEnd {
    /// Light that arrives at x, over the density of the light path.
    light: vec3f,
    /// What goes to the records of the vertex before, and what arrives at that vertex itself.
    reach: mat3x3f,
    step: vec3f,
    /// Density of x as sampled from the light's side, over that from the eye's.
    share: f32,
    /// Density of the vertex before as sampled from x.
    pdf_before: f32,
}

/// Densities of the connections at the vertices of a list, over that of the eye path which goes on from its first entry
/// to x, and of the light path that ends there.
fn connections_before(link: u32, end: LightEnd) -> f32 {
    var sum = 0.0;
    var place = link;
    var x = end;
    var connects = true;
    while place != NO_LINK && x.share > 0.0 {
        let entry = eye_links[place];
        if connects && entry.scale > 0.0 {
            let light = vec3f(
                counted(magnitude(x.light * x.reach[0])),
                counted(magnitude(x.light * x.reach[1])),
                counted(magnitude(x.light * x.reach[2])),
            );
            sum += x.share * entry.scale * sum_of(choice_densities(light, entry.records));
        }
        // The entry's own vertex becomes x.
        x = LightEnd(
            x.light * x.step / x.pdf_before,
            mat3x3f(entry.reach0, entry.reach1, entry.reach2),
            entry.step,
            x.share * x.pdf_before / entry.pdf_area,
            entry.pdf_before,
        );
        connects = entry.scale > 0.0;
        place = entry.before;
    }
    return sum;
}

/// The weight of a connection, and the density of all strategies that make the path, over those of its two sub-paths.
/// `arriving_light`: of the light vertex, at the eye vertex. Each side: its `mis_step`, and the density of its vertex
/// as sampled from the other end. `pdf_back`: that of the eye's last but one.
fn weigh_connection(
    eye_point: SurfacePoint, eye_vertex: PathVertex, partials: EyePartials, light_vertex: LightVertex, direction: vec3f,
    f_eye: vec3f, arriving_light: vec3f, eye_step: f32, pdf_back: f32, pdf_eye: f32, light_step: f32, pdf_light: f32,
) -> ConnectionWeight {
    let scale = density_scale(partials.depth) * thinning_at(eye_point.material);
    let densities = choice_densities(partials.light, partials.records);
    let end = LightEnd(
        arriving_light / pdf_eye,
        reach_of(eye_point, partials, direction),
        f_eye * step_to_before(eye_point, eye_vertex, partials),
        pdf_eye / eye_vertex.pdf_area,
        pdf_back,
    );
    let before = connections_before(partials.link, end);
    let density = scale * sum_of(densities) + before + eye_step * pdf_eye + light_step * pdf_light;
    return ConnectionWeight(scale * densities[partials.choice] / density, density);
}

/// Weight of an eye path that ends on a light.
fn hit_weight_of(previous_ratio: f32, partials: EyePartials, end: LightEnd) -> f32 {
    let before = connections_before(partials.link, end);
    return batch.hit_scale / (batch.hit_scale + before + previous_ratio * end.pdf_before * end.share);
}

#if area_lights
/// Weight of an eye path that met an emitting triangle; `light`: its index in `lights`.
fn emitter_weight(point: SurfacePoint, vertex: PathVertex, partials: EyePartials, light: u32) -> f32 {
    if (vertex.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_light = lights[light].pdf_select / point.area;
    var reach = mat3x3f();
    for (var k = 0u; k < CHOICE_ALL; k++) {
        if partials.link != NO_LINK && partials.reach[k] > 0.0 {
            let record = records[eye_links[partials.link].records[k]];
            reach[k] = vec3f(partials.reach[k] * emission_share(point, normalize(record.position - point.position)));
        }
    }
    let end = LightEnd(
        point_emission(point, vertex.world_from) * (point_presence(point) / pdf_light),
        reach,
        step_to_before(point, vertex, partials),
        pdf_light / vertex.pdf_area,
        emission_pdf_solid(point, vertex.world_from) * vertex.to_previous,
    );
    return hit_weight_of(vertex.ratio, partials, end);
}
#endif

#if environment
/// Weight of an eye path that left the scene along `direction`, which has the density `pdf_solid`.
fn environment_weight(previous: SubPath, partials: EyePartials, direction: vec3f, pdf_solid: f32) -> f32 {
    if (previous.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let cosine = abs(dot(direction, previous.normal));
    let pdf_light = environment_pdf_solid(direction);
    let reach = partials.reach;
    let end = LightEnd(
        environment_radiance(direction) / pdf_light,
        mat3x3f(vec3f(reach.x), vec3f(reach.y), vec3f(reach.z)),
        vec3f(cosine),
        pdf_light / pdf_solid,
        cosine * disk_pdf_area(),
    );
    return hit_weight_of(previous.ratio, partials, end);
}
#endif
