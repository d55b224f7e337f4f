// The connection of an eye vertex and a vertex of the light cache, whatever the surfaces are. lib/strategies has the
// parts; lib/connect_lambert is the form for surfaces that need less.

/// A connection but for visibility and for what its eye path carries.
struct Connection {
    link: Link,
    /// The light's weight, both BSDFs, and the geometry and absorption between.
    light: vec3f,
    /// Share of this strategy.
    weight: f32,
    /// For training. The BSDF at the eye's end; at the light's, absorption between included. Geometry.
    f_eye: vec3f,
    f_light: vec3f,
    geometry: f32,
    /// Density of all strategies that make the path, over those of its two sub-paths.
    density: f32,
    /// Density per area of the light vertex, and of the one before it, as the eye's side samples them.
    pdf_light: f32,
    pdf_back: f32,
}

/// Connects an eye vertex that is no delta vertex.
fn connect(eye: EyeEnd, partials: EyePartials, light_vertex: LightVertex) -> Connection {
    let kind = kind_of(light_vertex);
    var connection: Connection;
    connection.link = link_to(eye.point, light_vertex, kind);
    connection.weight = 1.0;
    let link = connection.link;
    if link.to_light == 0.0 {
        return connection;
    }
    // The light's end: emission here, scattering below.
    var f_light = vec3f(1.0);
    var light_step = light_vertex.ratio / light_vertex.pdf_area;
    var pdf_eye = 0.0;
    if kind != 0u {
        let emission = emitted(light_vertex, kind, link.light_point, -link.direction);
        f_light = vec3f(emission.x);
        pdf_eye = emission.y * link.to_eye;
    }
    var eye_step = 0.0;
    var eye_pdf_back = 0.0;
    var f_eye: vec3f;
    let lit = any(light_vertex.weight * f_light > vec3f(0.0));
    var light_surface: Surface;
    var light_frame: ShadingFrame;
    if kind == 0u {
        light_surface = point_surface(link.light_point);
        light_frame = point_frame(link.light_point);
    }
    // First the eye's end, then the light's: one call site for the whole BSDF.
    for (var turn = 0u; turn < select(1u, 2u, kind == 0u) && lit; turn++) {
        let at_eye = turn == 0u;
        var surface = light_surface;
        var frame = light_frame;
        var world_from = light_vertex.world_from;
        var world_to = -link.direction;
        if at_eye {
            surface = eye.surface;
            frame = eye.frame;
            world_from = eye.vertex.world_from;
            world_to = link.direction;
        }
        let value = shading_evaluate(surface, frame, world_from, world_to, at_eye);
        let survives = survival(surface);
        if at_eye {
            f_eye = value.f;
            connection.pdf_light = value.pdf_solid * survives * link.to_light;
            eye_step = vertex_step(eye.vertex, value.pdf_back_solid * survives, false);
            eye_pdf_back = value.pdf_back_solid * survives * eye.vertex.to_previous;
            if !any((light_vertex.weight > vec3f(0.0)) & (f_eye > vec3f(0.0))) {
                // Nothing to do at the light's end.
                break;
            }
        } else {
            f_light = value.f;
            pdf_eye = value.pdf_solid * survives * link.to_eye;
            connection.pdf_back = value.pdf_back_solid * survives * light_vertex.to_previous;
            let edge = cached_edge(light_vertex, link.light_point, world_to) * scale_from_deep(eye_depth(partials) + 1u);
            light_step = mis_step(light_vertex.ratio, connection.pdf_back, edge, light_vertex.pdf_area);
        }
    }
    var medium = medium_towards(eye.point, link.direction);
    if kind == 0u {
        medium = medium_between(medium, link.light_point, -link.direction);
    }
    f_light *= transmittance(medium, link.distance);
    let light = light_vertex.weight * f_light;
    let geometry = abs(dot(link.direction, eye.point.world_ng)) * link.to_light;
    connection.light = light * f_eye * geometry;
    connection.f_eye = f_eye;
    connection.f_light = f_light;
    connection.geometry = geometry;
    let weight = weigh_connection(
        eye.point, eye.vertex, partials, light_vertex, link.direction, f_eye, light * geometry,
        eye_step, eye_pdf_back, pdf_eye, light_step, connection.pdf_light,
    );
    connection.weight = weight.weight;
    connection.density = weight.density;
    return connection;
}
