#import bind/batch
#import bind/records
#import lib/color

// How connections are drawn by records one at a time, and what weights make of it. An eye vertex z has four choices: each of
// the three records nearest to it, and all vertices of the cache alike. With P of choice k it draws y from M light paths in
// proportion to the light r_k that y brings to the record; such a draw is worth, in the terms of lib/mis,
//
//   v_k = P_k M / ((M - 1) max(1e-3, Q_k / r_k) + 1)   0 where r_k is; r and Q are 1 and L where all are drawn alike
//
// where Q_k, which earlier iterations tell, is about the mean of r_k over a light path, and L the mean number of vertices
// on one. P is fixed before the iteration's light paths are: a record has its share whatever they bring to it, so that all
// strategies agree on it. Nabata, Iwasaki, Dobashi, Resampling-aware Weighting Functions for Bidirectional Path Tracing
// Using Multiple Light Sub-Paths, 2020.

/// The choice of all vertices alike; 0 to 2 are records, from near to far.
const CHOICE_ALL: u32 = 3u;
const CHOICES: u32 = 4u;
/// r / Q counts this much at most: Nabata et al.
const MOST_OVER_Q: f32 = 1000.0;
/// Light that a record counts. Sums over all vertices are then finite, and none is 0 unless all are.
const LEAST_COUNTED: f32 = 0x1p-100;
const MOST_COUNTED: f32 = 0x1p+90;

/// r, of light that a record gets.
fn counted(light: f32) -> f32 {
    if !is_drawable(light) || light < LEAST_COUNTED {
        return 0.0;
    }
    return select(MOST_COUNTED, light, light < MOST_COUNTED);
}

/// 1 / Q of a record; 0 where it is not known, or where there is none.
fn inv_q_of(record: u32) -> f32 {
    if record == NO_RECORD {
        return 0.0;
    }
    return records[record].inv_q;
}

/// Places that may hold a record. A constant in its place would make drivers unroll loops that have much in them.
fn records_among(near: vec3u) -> u32 {
    return select(CHOICE_ALL, 0u, near.x == NO_RECORD);
}

/// P of each choice at an eye vertex with these records.
fn choice_shares(near: vec3u) -> vec4f {
    var shares = vec4f(0.0, 0.0, 0.0, 1.0);
    for (var k = 0u; k < CHOICE_ALL; k++) {
        if inv_q_of(near[k]) > 0.0 {
            shares[k] = 1.0 / f32(CHOICES);
            shares.w -= shares[k];
        }
    }
    return shares;
}

/// v of each choice; `light`: r.
fn choice_densities(light: vec3f, near: vec3u) -> vec4f {
    let paths = f32(batch.light_path_count);
    var densities = choice_shares(near) * paths;
    densities.w /= (paths - 1.0) * batch.vertices_per_path + 1.0;
    for (var k = 0u; k < CHOICE_ALL; k++) {
        let product = light[k] * inv_q_of(near[k]);
        let over_q = select(MOST_OVER_Q, product, product < MOST_OVER_Q);
        densities[k] *= select(0.0, over_q / (paths - 1.0 + over_q), product > 0.0);
    }
    return densities;
}

fn sum_of(densities: vec4f) -> f32 {
    return dot(densities, vec4f(1.0));
}
