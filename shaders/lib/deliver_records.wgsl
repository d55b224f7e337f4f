#import bind/light_cache
#import bind/lights
#import bind/queue
#import lib/color
#import lib/connections
#import lib/strategies
#import lib/training

// The paths that find light are written down for training, each with the density of all ways to find it.

#if environment
/// A ray that left the scene, from `previous`.
fn deliver_sky(ray: PathRay, previous: SubPath, depth: u32, sky: vec3f, weight: f32) {
    if depth > 0u {
        let cosine = abs(dot(ray.direction, previous.normal));
        let at = sphere_to_square(ray.direction);
        write_hit(ray, sky, vec3f(1.0), weight, batch.hit_scale, ray.pdf_solid, cosine, environment_map.light, at);
    }
}
#endif

#if area_lights
/// A ray that met an emitting triangle; `light`: its index in `lights`. `through`: what the ray's way lets pass;
/// `ray.throughput` has it.
fn deliver_emitter(
    ray: PathRay, point: SurfacePoint, vertex: PathVertex, depth: u32, emission: vec3f, through: vec3f, weight: f32,
    light: u32,
) {
    if depth > 0u {
        let geometry = abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous;
        write_hit(
            ray, emission, through, weight, batch.hit_scale, vertex.pdf_area, geometry, light, point.b.yz,
        );
    }
}
#endif

/// A vertex of an eye path; `f`: the BSDF on the way to the next, 0 where the path ends.
fn deliver_vertex(
    ray: PathRay, point: SurfacePoint, vertex: PathVertex, depth: u32, f: vec3f, through: vec3f, is_delta: bool,
) {
    let geometry = abs(dot(vertex.world_from, point.world_ng)) * vertex.to_previous;
    write_vertex(point, vertex, ray.path, depth, is_delta, f * through, geometry);
}

/// A connection; whether its ends see each other goes to the record's slot of `radiance`.
fn deliver_connection(
    shadow: ShadowRay, slot: u32, ray: PathRay, through: vec3f, light_vertex: LightVertex, connection: Connection,
    contribution: vec3f,
) {
    var end: TrainingEnd;
    end.emitted = light_vertex.weight / connection.density;
    end.path = ray.path;
    end.f = connection.f_eye * through;
    end.depth_sampled = shadow.depth | ((counts.connection_round * CONNECTIONS_IN_FLIGHT + slot + 1u) << 16u);
    end.f_light = connection.f_light;
    end.vertex = light_path_offsets[light_vertex.path] + number_of(light_vertex);
    end.share = share_at(shadow.depth);
    end.contribution =
        magnitude(ray.throughput * through * connection.light) * (end.share / connection.density);
    end.geometry = connection.geometry;
    end.pdf_light = connection.pdf_light;
    end.pdf_back = connection.pdf_back;
    end.direction = connection.link.direction;
    var test = shadow;
    test.contribution = vec3f(1.0);
    test.slot = write_end(end);
    if test.slot < arrayLength(&training_ends) {
        shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = test;
    }
}
