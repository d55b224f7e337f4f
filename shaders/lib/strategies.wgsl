#import bind/batch
#import bind/light_cache
#import lib/camera
#import lib/emission
#import lib/light
#import lib/medium
#import lib/mis
#import lib/subpath
#if subspaces
#import lib/subspaces
#endif

// The three ways to finish a path, each with its weight: an eye vertex and a vertex of the light cache are connected,
// an eye path hits a light, a light vertex is connected to the camera.

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

/// A connection but for visibility and for what its eye path carries.
struct Connection {
    link: Link,
    /// The light's weight, both BSDFs, and the geometry and absorption between.
    light: vec3f,
    /// Share of this strategy.
    weight: f32,
    /// For those who learn from it. The BSDF at the eye's end; at the light's, absorption between included. Geometry.
    f_eye: vec3f,
    f_light: vec3f,
    geometry: f32,
    /// Density of all strategies that make the path, over those of its two sub-paths.
    density: f32,
    /// Density per area of the light vertex, and of the one before it, as the eye's side samples them.
    pdf_light: f32,
    pdf_back: f32,
}

/// An eye vertex's part in weights by subspaces: its `shares_in`, what the last segment absorbs included, and
/// `eye_labels`.
struct EyeShares {
    share: vec4f,
    labels: vec2u,
}

#if subspaces
/// `shares_in` of the ray that leaves an eye vertex along `direction`, for which the BSDF is `f`.
fn departing_share(
    point: SurfacePoint, arrival: Arrival, shares: EyeShares, direction: vec3f, f: vec3f, is_delta: bool,
) -> vec4f {
    let label = eye_light_label(point, direction, shares.labels.y);
    let before = select(eye_share(arrival.flags, shares.share, label), 0.0, is_delta);
    let cos_from = abs(dot(arrival.world_from, point.world_ng));
    let continued = shares.share.rgb * f * (cos_from * arrival.to_previous) + before;
    return vec4f(continued / arrival.pdf_area, bitcast<f32>(shares.labels.x));
}
#endif

/// Connects an eye vertex that is no delta vertex.
fn connect(eye_point: SurfacePoint, arrival: Arrival, shares: EyeShares, vertex: LightVertex) -> Connection {
    let kind = kind_of(vertex);
    var connection: Connection;
    connection.link = link_to(eye_point, vertex, kind);
    connection.weight = 1.0;
    let link = connection.link;
    if link.to_light == 0.0 {
        return connection;
    }
    // The light's end: emission here, scattering below.
    var f_light = vec3f(1.0);
    var light_step = vertex.ratio / vertex.pdf_area;
    var pdf_eye = 0.0;
    if kind != 0u {
        let emission = emitted(vertex, kind, link.light_point, -link.direction);
        f_light = vec3f(emission.x);
        pdf_eye = emission.y * link.to_eye;
    }
    var eye_step = 0.0;
    var f_eye: vec3f;
    let lit = any(vertex.weight * f_light > vec3f(0.0));
    // First the eye's end, then the light's: one call site for the whole BSDF.
    for (var turn = 0u; turn < select(1u, 2u, kind == 0u) && lit; turn++) {
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
        if at_eye {
            f_eye = value.f;
            connection.pdf_light = value.pdf_solid * survives * link.to_light;
            eye_step = arrival_step(arrival, value.pdf_back_solid * survives, false);
            if !any((vertex.weight > vec3f(0.0)) & (f_eye > vec3f(0.0))) {
                // Nothing to do at the light's end.
                break;
            }
        } else {
            f_light = value.f;
            pdf_eye = value.pdf_solid * survives * link.to_eye;
            connection.pdf_back = value.pdf_back_solid * survives * vertex.to_previous;
#if subspace_directions
            let edge = light_edge(point, world_to, vertex.edge, vertex.depth_kind >> 20u);
#else
            let edge = vertex.edge;
#endif
            light_step = mis_step(vertex.ratio, connection.pdf_back, edge, vertex.pdf_area);
        }
    }
    var medium = medium_towards(eye_point, link.direction);
    if kind == 0u {
        medium = medium_between(medium, link.light_point, -link.direction);
    }
    f_light *= transmittance(medium, link.distance);
    let light = vertex.weight * f_light;
    let geometry = abs(dot(link.direction, eye_point.world_ng)) * link.to_light;
    connection.light = light * f_eye * geometry;
    connection.f_eye = f_eye;
    connection.f_light = f_light;
    connection.geometry = geometry;
#if subspaces
    let edge = connection_share(shares.labels.x, vertex.number_label >> 16u) * magnitude(vertex.weight);
    let share = departing_share(eye_point, arrival, shares, link.direction, f_eye, false);
    let nearer = magnitude(light * geometry * share.rgb);
    connection.density = edge + nearer + eye_step * pdf_eye + light_step * connection.pdf_light;
    connection.weight = edge / connection.density;
#else
    connection.weight =
        connection_weight(batch.connection_density, eye_step, pdf_eye, light_step, connection.pdf_light);
#endif
    return connection;
}

#if area_lights
/// Weight of an eye path that met an emitting triangle; `light`: its index in `lights`.
fn emitter_weight(point: SurfacePoint, arrival: Arrival, shares: EyeShares, light: u32) -> f32 {
    if (arrival.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = emission_pdf_solid(point, arrival.world_from) * arrival.to_previous;
    let pdf_light = lights[light].pdf_select / point.area;
#if subspaces
    let emission = point_emission(point, arrival.world_from) * point_presence(point);
    let geometry = abs(dot(arrival.world_from, point.world_ng)) * arrival.to_previous;
    let edge = eye_share(arrival.flags, shares.share, source_label(light, point.b.yz));
    let others = edge * magnitude(emission) + magnitude(shares.share.rgb * emission) * geometry
        + arrival.ratio * pdf_previous * pdf_light;
    return 1.0 / (1.0 + others / arrival.pdf_area);
#else
    return hit_weight(arrival.edge, arrival.ratio, pdf_previous, pdf_light, arrival.pdf_area);
#endif
}
#endif

#if environment
/// Weight of an eye path that left the scene along `direction`, which has the density `pdf_solid`.
fn environment_weight(previous: SubPath, shares: EyeShares, direction: vec3f, pdf_solid: f32) -> f32 {
    if (previous.flags & SUBPATH_CAMERA) != 0u {
        return 1.0;
    }
    let pdf_previous = abs(dot(direction, previous.normal)) * disk_pdf_area();
    let pdf_light = environment_pdf_solid(direction);
#if subspaces
    let radiance = environment_radiance(direction);
    let cosine = abs(dot(direction, previous.normal));
    let edge = eye_share(previous.flags, shares.share, source_label(ENVIRONMENT_LIGHT, sphere_to_square(direction)));
    let others = edge * magnitude(radiance) + magnitude(shares.share.rgb * radiance) * cosine
        + previous.ratio * pdf_previous * pdf_light;
    return 1.0 / (1.0 + others / pdf_solid);
#else
    return hit_weight(edge_density(previous.flags), previous.ratio, pdf_previous, pdf_light, pdf_solid);
#endif
}
#endif

/// A connection of a light path's vertex to the camera, but for visibility and for what the path carries; `weight` is
/// the share of this strategy.
struct CameraConnection {
    light: vec3f,
    weight: f32,
}

fn connect_camera(point: SurfacePoint, arrival: Arrival, view: CameraView) -> CameraConnection {
    let surface = point_surface(point);
    let value = shading_evaluate(surface, point_frame(point), arrival.world_from, view.direction, false);
    let pdf_eye = abs(dot(view.direction, point.world_ng)) * view.pdf_area;
    let step = arrival_step(arrival, value.pdf_back_solid * survival(surface), false);
    return CameraConnection(
        value.f * (pdf_eye / f32(batch.light_path_count)),
        connection_weight(batch.camera_paths, 0.0, 0.0, step, pdf_eye),
    );
}
