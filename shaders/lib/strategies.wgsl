#import bind/batch
#import bind/light_cache
#import lib/camera
#if lambert_vertices
#import lib/connect_lambert
#else
#import lib/connect
#endif
#import lib/emission
#import lib/light
#import lib/medium
#import lib/mis
#import lib/subpath
#import lib/weights

// The three ways to finish a path, each with its weight: an eye vertex and a vertex of the light cache are connected
// (`connect` of lib/connect, or of lib/connect_lambert), an eye path hits a light (lib/weights), a light vertex is
// connected to the camera.

/// An eye vertex that connects.
struct EyeEnd {
    point: SurfacePoint,
    vertex: PathVertex,
    surface: Surface,
    frame: ShadingFrame,
}

fn eye_end(point: SurfacePoint, vertex: PathVertex) -> EyeEnd {
    return EyeEnd(point, vertex, point_surface(point), point_frame(point));
}

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
            return vec2f(emission_share(point, direction), emission_pdf_solid(point, direction));
        }
#endif
#if punctual_lights
        case LIGHT_POINT + 1u, LIGHT_SPOT + 1u: {
            let light = punctual_lights[index_of(vertex)];
            let is_spot = kind == LIGHT_SPOT + 1u;
            let falloff = emission_falloff(light, direction, is_spot);
            return vec2f(falloff, uniform_cone_pdf_solid(light.cone));
        }
#endif
        default: {
            return vec2f(1.0, disk_pdf_area());
        }
    }
}

/// Unit direction to an infinitely far light.
fn direction_to_light(vertex: LightVertex, kind: u32) -> vec3f {
#if lambert_vertices
#if environment
    if kind == LIGHT_ENVIRONMENT + 1u {
        return square_to_sphere(vec2f(vertex.b1, vertex.b2));
    }
#endif
#if punctual_lights
    return -punctual_lights[index_of(vertex)].direction;
#else
    return vec3f(0.0);
#endif
#else
    return vertex.world_from;
#endif
}

fn link_to(point: SurfacePoint, vertex: LightVertex, kind: u32) -> Link {
    var link: Link;
    if kind == LIGHT_ENVIRONMENT + 1u || kind == LIGHT_DIRECTIONAL + 1u {
        link.direction = direction_to_light(vertex, kind);
        link.distance = MAX_FLOAT;
        link.to_light = 1.0;
        link.to_eye = abs(dot(link.direction, point.world_ng));
        return link;
    }
    var position: vec3f;
    var is_surface = true;
#if punctual_lights
    if kind > LIGHT_TRIANGLE + 1u {
        position = punctual_lights[index_of(vertex)].position;
        is_surface = false;
    }
#endif
    if is_surface {
        link.light_point = surface_point(index_of(vertex), vertex.b1, vertex.b2);
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

/// The ray that tests a link.
fn link_ray(point: SurfacePoint, link: Link, kind: u32) -> ShadowRay {
    let origin = ray_origin(point, link.direction);
    if link.distance == MAX_FLOAT {
        return ShadowRay(origin, 0u, link.direction, MAX_FLOAT, vec3f(0.0), 0u);
    }
    var end = point.position + link.direction * link.distance;
    if kind <= LIGHT_TRIANGLE + 1u {
        end = ray_end(link.light_point, link.direction, link.distance);
    }
    return ShadowRay(origin, 0u, end - origin, 1.0 - 0x1p-20, vec3f(0.0), 0u);
}

/// A connection of a light path's vertex to the camera, but for visibility and for what the path carries; `weight` is
/// the share of this strategy.
struct CameraConnection {
    light: vec3f,
    weight: f32,
}

/// A light path's vertex as the first that the camera sees, so that the one before it is the second.
fn seen_by_camera(vertex: PathVertex, mis: LightMis) -> PathVertex {
    var seen = vertex;
    seen.edge *= scale_from_deep(0u);
    seen.ratio += edge_before(mis) * (scale_from_deep(1u) - 1.0);
    return seen;
}

/// `nominal`: density of an unguided light path over that of this one.
fn connect_camera(point: SurfacePoint, vertex: PathVertex, view: CameraView, nominal: f32) -> CameraConnection {
    let surface = point_surface(point);
    let value = shading_evaluate(surface, point_frame(point), vertex.world_from, view.direction, false);
    let pdf_eye = abs(dot(view.direction, point.world_ng)) * view.pdf_area;
    let step = vertex_step(vertex, value.pdf_back_solid * survival(surface), false);
    return CameraConnection(
        value.f * (pdf_eye / f32(batch.light_path_count)),
        connection_weight(batch.camera_paths * nominal, 0.0, 0.0, step, pdf_eye),
    );
}
