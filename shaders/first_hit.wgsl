#import bind/batch
#import bind/page
#import bind/queue
#import lib/hit

// What the camera sees first: albedo, shading normal and distance, summed over a batch's samples of each pixel.
// Misses add to nothing but the count. With `through_mirrors` albedo and normal are those of what is seen in mirrors and
// through smooth glass, as far as mirror_follow went.

struct FirstHitPixel {
    albedo: vec3f,
    depth: f32,
    normal: vec3f,
    /// Samples that met a surface.
    hits: u32,
}

@group(2) @binding(2) var<storage, read_write> first_hits: array<FirstHitPixel>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= batch.pixel_count {
        return;
    }
    let place = in_page(batch.first_pixel + index);
    var pixel = first_hits[place];
    for (var i = 0u; i < batch.sample_count; i++) {
        let path = i * batch.pixel_count + index;
        let hit = hits[path];
#if through_mirrors
        let followed = (paths_in[path].depth_medium & 0xffffu) > 0u;
        if followed {
            pixel.depth += paths_in[path].pdf_solid;
            pixel.hits++;
        }
        let through = paths_in[path].throughput;
#else
        let followed = false;
        let through = vec3f(1.0);
#endif
        if hit.triangle != NO_TRIANGLE {
            let point = surface_point(hit.triangle, hit.b1, hit.b2);
            let facing = select(-1.0, 1.0, dot(paths_in[path].direction, point.world_ng) < 0.0);
            pixel.albedo += through * bsdf_albedo(point_surface(point));
            pixel.normal += facing * point_frame(point).shading.normal;
            if !followed {
                pixel.depth += camera.before + hit.t;
                pixel.hits++;
            }
        }
    }
    first_hits[place] = pixel;
}
