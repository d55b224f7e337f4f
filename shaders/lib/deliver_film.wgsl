#import bind/batch
#import bind/queue
#import lib/strategies

// Light that eye paths find goes to the film, each strategy with its weight.

/// A light that the ray of `path` hit at vertex `depth`.
fn deliver_hit(path: u32, depth: u32, light: vec3f, weight: f32) {
    if (batch.only_s != EVERY_STRATEGY) && (batch.only_s != 0u || batch.only_t != depth + 2u) {
        return;
    }
    radiance[path * CONNECTIONS_IN_FLIGHT] += vec4f(light * select(1.0, weight, batch.weighted != 0u), 0.0);
}

#if environment
/// A ray that left the scene, from `previous`.
fn deliver_sky(ray: PathRay, previous: SubPath, depth: u32, sky: vec3f, weight: f32) {
    deliver_hit(ray.path, depth, ray.throughput * sky, weight);
}
#endif

#if area_lights
/// A ray that met an emitting triangle; `light`: its index in `lights`. `through`: what the ray's way lets pass;
/// `ray.throughput` has it.
fn deliver_emitter(
    ray: PathRay, point: SurfacePoint, vertex: PathVertex, depth: u32, emission: vec3f, through: vec3f, weight: f32,
    light: u32,
) {
    deliver_hit(ray.path, depth, ray.throughput * emission, weight);
}
#endif

/// A vertex of an eye path is nothing to see.
fn deliver_vertex(
    ray: PathRay, point: SurfacePoint, vertex: PathVertex, depth: u32, f: vec3f, through: vec3f, is_delta: bool,
) {}

/// A connection that carries `contribution`, its weight included; `shadow` tests it. `slot`: among the connections of the
/// vertex.
fn deliver_connection(
    shadow: ShadowRay, slot: u32, ray: PathRay, through: vec3f, light_vertex: LightVertex, connection: Connection,
    contribution: vec3f,
) {
    var test = shadow;
    test.contribution = contribution;
    test.slot = ray.path * CONNECTIONS_IN_FLIGHT + slot;
    shadow_rays[atomicAdd(&counts.shadow_out, 1u)] = test;
}
