#import bind/queue
#import bind/training
#import lib/color
#import lib/subpath
#import lib/subspaces
#import lib/thinning

// Writing down the paths that the host learns from.

/// Writes an end; the result is the slot of `radiance` that its visibility goes to.
fn write_end(end: TrainingEnd) -> u32 {
    let slot = atomicAdd(&training_counts.ends, 1u);
    if slot < arrayLength(&training_ends) {
        training_ends[slot] = end;
        radiance[slot] = vec4f(0.0);
    }
    return slot;
}

/// A light that the ray hit. `weight`: density of hitting it, `share` times, over that of all ways to find it. `pdf`: of
/// hitting it, in the light's measure. `through`: what the ray's way lets pass; `ray.throughput` has it.
fn write_hit(
    ray: PathRay, emission: vec3f, through: vec3f, weight: f32, share: f32, pdf: f32, geometry: f32, light: u32,
    at: vec2f,
) {
    var end: TrainingEnd;
    end.emitted = emission * (weight / share / pdf);
    end.path = ray.path;
    end.depth_sampled = (ray.depth_medium & 0xffffu) - 1u;
    end.f_light = through;
    end.vertex = NO_LIGHT_VERTEX;
    end.contribution = magnitude(ray.throughput * emission) * weight;
    end.p0 = weight / share;
    end.share = share;
    end.geometry = geometry;
    end.light = light;
    end.at = at;
    end.direction = ray.direction;
    if end.contribution > 0.0 {
        write_end(end);
    }
}

/// A vertex of an eye path; `f`: the BSDF on the way to the next, 0 where the path ends, times what the way here lets
/// pass.
fn write_vertex(
    point: SurfacePoint, vertex: PathVertex, path: u32, depth: u32, is_delta: bool, f: vec3f, geometry: f32,
) {
    let slot = atomicAdd(&training_counts.vertices, 1u);
    if slot < arrayLength(&training_vertices) {
        training_vertices[slot] = TrainingVertex(
            point.position,
            path,
            label_normal(point, vertex.world_from),
            depth | select(thinning_units(point.material) << 16u, 0u, is_delta),
            vertex.world_from,
            vertex.pdf_area,
            f,
            geometry,
        );
    }
}
