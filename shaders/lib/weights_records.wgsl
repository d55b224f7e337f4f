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
#import lib/nearest_records
#import lib/subpath
#import lib/thinning

// Weights that know of the resampling by records: an eye vertex z draws y from M light paths in proportion, about, to the
// light r that y brings to z. Such a draw is worth less than one in exact proportion, since M are no more than M. In the
// terms of lib/mis
//
//   c(z, y) = S M x / (M - 1 + x),   x = 3/4 mean of r / Q_k over the records nearest to z + 1/4 / L
//   r = |w_y f(y) G(y, z)|
//
// where Q_k, which earlier iterations tell, is about the mean of r over a light path, L the mean number of vertices on
// one, and S the scale of z's depth times its thinning. Nabata, Iwasaki, Dobashi, Resampling-aware Weighting Functions for
// Bidirectional Path Tracing Using Multiple Light Sub-Paths, 2020, in the form that Su, Li, Wang 2022 compare with: all
// records in one density, and none asked whether it sees y.
//
// c is not linear in |w|, so that no sum for all vertices before is enough: the eye's side has a list of its vertices,
// the last one first (`eye_links`), and goes along it.

/// Of a ray that leaves an eye vertex: its place in `eye_links`.
alias EyeMis = u32;

/// What weights need of an eye vertex: the list of those before, its own 1 / Q_k, and what the last segment lets pass.
struct EyePartials {
    link: u32,
    depth: u32,
    through: vec3f,
    inv_q: vec3f,
}

/// r / Q_k counts this much at most: Su, Li, Wang.
const MOST_OVER_Q: f32 = 1000.0;
/// Share of x that does not depend on records.
const UNIFORM_SHARE: f32 = 0.25;

/// 1 / Q_k of records, 0 in the place of one that is not there.
fn inv_q_of(nearest: vec3u) -> vec3f {
    var inv_q = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        if nearest[i] != NO_RECORD {
            inv_q[i] = records[nearest[i]].inv_q;
        }
    }
    return inv_q;
}

/// c over S: `arriving`: r.
fn resampling_density(arriving: f32, inv_q: vec3f) -> f32 {
    let over_q = arriving * inv_q;
    let kept = select(vec3f(MOST_OVER_Q), over_q, over_q < vec3f(MOST_OVER_Q));
    let there = select(vec3f(0.0), vec3f(1.0), inv_q > vec3f(0.0));
    let count = there.x + there.y + there.z;
    let even = UNIFORM_SHARE / batch.vertices_per_path;
    let x = select((1.0 - UNIFORM_SHARE) * dot(kept, there) / max(count, 1.0) + even, even / UNIFORM_SHARE, count == 0.0);
    let paths = f32(batch.light_path_count);
    return paths * x / (paths - 1.0 + x);
}

/// Of the vertex that a ray of the queue has just reached.
fn load_eye_partials(index: u32, depth: u32) -> EyePartials {
    return EyePartials(eye_ends_in[index], depth, vec3f(1.0), inv_q_of(eye_records[index].xyz));
}

fn absorb(partials: EyePartials, through: vec3f) -> EyePartials {
    var absorbed = partials;
    absorbed.through *= through;
    return absorbed;
}

fn eye_depth(partials: EyePartials) -> u32 {
    return partials.depth;
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
    eye_links[slot] = EyeLink(
        eye_step_light(point, vertex, partials, f),
        partials.link,
        partials.inv_q,
        pdf_back,
        vertex.pdf_area,
        select(scale, 0.0, is_delta),
        0u,
        0u,
    );
    return slot;
}

/// Of light that arrives at an eye vertex, what goes on to the vertex before.
fn eye_step_light(point: SurfacePoint, vertex: PathVertex, partials: EyePartials, f: vec3f) -> vec3f {
    return f * partials.through * (abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous);
}

/// Of the ray in a slot of the queue.
fn store_eye_mis(slot: u32, mis: EyeMis) {
    eye_ends_out[slot] = mis;
}

/// c, with the scale of DEEP, between a light path's vertex, where light of `throughput` arrives, and the one before it.
fn edge_so_far(point: SurfacePoint, vertex: PathVertex, mis: LightMis, throughput: vec3f) -> f32 {
    if (vertex.flags & SUBPATH_DELTA) != 0u {
        return 0.0;
    }
    let inv_q = inv_q_of(nearest_records(point.position));
    return light_scale(point) * resampling_density(magnitude(throughput) * vertex.pdf_area, inv_q);
}

fn edge_towards(
    point: SurfacePoint, vertex: PathVertex, mis: LightMis, world_to: vec3f, throughput: vec3f,
) -> f32 {
    return edge_so_far(point, vertex, mis, throughput);
}

/// Densities of the connections at the vertices of a list, over that of the eye path which goes on from its first entry
/// to a vertex x, and of the light path that ends at x. `light`: what the latter brings to the entry, over its density.
/// `share`: density of x as sampled from the light's side, over that from the eye's. `pdf_light`: density of the entry's
/// vertex as sampled from x.
fn connections_before(link: u32, light: vec3f, share: f32, pdf_light: f32) -> f32 {
    var sum = 0.0;
    var place = link;
    var arriving = light;
    var ratio = share;
    var pdf = pdf_light;
    var connects = true;
    while place != NO_LINK && ratio > 0.0 {
        let entry = eye_links[place];
        if connects {
            sum += ratio * entry.scale * resampling_density(magnitude(arriving), entry.inv_q);
        }
        // The entry's own vertex becomes x.
        ratio *= pdf / entry.pdf_area;
        arriving *= entry.step / pdf;
        pdf = entry.pdf_before;
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
    let edge = scale * resampling_density(magnitude(arriving_light), partials.inv_q);
    let going_on = arriving_light * eye_step_light(eye_point, eye_vertex, partials, f_eye) / pdf_eye;
    let before = connections_before(partials.link, going_on, pdf_eye / eye_vertex.pdf_area, pdf_back);
    let density = edge + before + eye_step * pdf_eye + light_step * pdf_light;
    return ConnectionWeight(edge / density, density);
}

/// Weight of an eye path that ends on a light with `light` arriving at its last vertex over the density of the point on
/// the light, and with `share` of the densities of that point.
fn hit_weight_of(previous_ratio: f32, partials: EyePartials, light: vec3f, share: f32, pdf_previous: f32) -> f32 {
    let before = connections_before(partials.link, light, share, pdf_previous);
    return batch.hit_scale / (batch.hit_scale + before + previous_ratio * pdf_previous * share);
}

#if area_lights
/// Weight of an eye path that met an emitting triangle; `light`: its index in `lights`.
fn emitter_weight(point: SurfacePoint, vertex: PathVertex, partials: EyePartials, light: u32) -> f32 {
    if (vertex.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = emission_pdf_solid(point, vertex.world_from) * vertex.to_previous;
    let pdf_light = lights[light].pdf_select / point.area;
    let emission = point_emission(point, vertex.world_from) * point_presence(point);
    let going_on = eye_step_light(point, vertex, partials, emission) / pdf_light;
    return hit_weight_of(vertex.ratio, partials, going_on, pdf_light / vertex.pdf_area, pdf_previous);
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
    let going_on = environment_radiance(direction) * (cosine / pdf_light);
    return hit_weight_of(previous.ratio, partials, going_on, pdf_light / pdf_solid, cosine * disk_pdf_area());
}
#endif
