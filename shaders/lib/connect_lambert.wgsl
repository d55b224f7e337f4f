#import lib/lambert

// The connection of an eye vertex z and a vertex y of the light cache where all surfaces scatter by Lambert's law
// alone: lib/connect without what does not depend on the connection's direction.
//
// The density of scattering back to where a sub-path came from is that of the direction back alone, so that the
// `mis_step` of both ends is known on arrival; y has it stored, and its BSDF is in its weight but for the side of the
// surface. In the terms of lib/mis and lib/weights_subspaces, E the colour A of z's `eye_mis_of_bounce`, the densities of
// the other strategies are
//
//   nearer to the light   step(y) pE(y|z)
//   nearer to the eye     |w_y f_y G(y, z) E(z)|, and step(z) pL(z|y)
//
// pE(y|z) the density of y as sampled from z.

/// A connection but for visibility and for what its eye path carries.
struct Connection {
    link: Link,
    /// The light's weight, both BSDFs, and the geometry between.
    light: vec3f,
    /// Share of this strategy.
    weight: f32,
}

/// Of a light vertex: share of its weight that leaves along `direction`, and the density of that direction.
fn leaving(light_vertex: LightVertex, kind: u32, point: SurfacePoint, direction: vec3f) -> vec2f {
    if kind != 0u {
        return emitted(light_vertex, kind, point, direction);
    }
    let w_to = shading_direction(point_frame(point), direction);
    let lit_side = (w_to.cos_geometric > 0.0) == is_lit_from_front(light_vertex);
    return select(vec2f(0.0), vec2f(1.0, light_vertex.pdf_scale * abs(w_to.cos_shading)), is_open(w_to) && lit_side);
}

fn connect(eye: EyeEnd, partials: EyePartials, light_vertex: LightVertex) -> Connection {
    let kind = kind_of(light_vertex);
    var connection: Connection;
    connection.link = link_to(eye.point, light_vertex, kind);
    connection.weight = 1.0;
    let link = connection.link;
    let w_from = shading_direction(eye.frame, eye.vertex.world_from);
    let w_to = shading_direction(eye.frame, link.direction);
    let reflects = is_open(w_from) && is_open(w_to) && (w_from.cos_geometric > 0.0) == (w_to.cos_geometric > 0.0);
    let leaves = leaving(light_vertex, kind, link.light_point, -link.direction);
    if link.to_light == 0.0 || leaves.x == 0.0 || !reflects {
        return connection;
    }
    let f = lambert_f(eye.surface, w_to);
    let pdf_scale = lambert_pdf_scale(eye.surface);
    let pdf_back_solid = pdf_scale * abs(w_from.cos_shading);
    let eye_step = vertex_step(eye.vertex, pdf_back_solid, false);
    let pdf_light = pdf_scale * abs(w_to.cos_shading) * link.to_light;
    let pdf_eye = leaves.y * link.to_eye;
    let arriving_light = light_vertex.weight * (leaves.x * abs(w_to.cos_geometric) * link.to_light);
    connection.light = arriving_light * f;
    let light_step =
        light_vertex.step + light_vertex.edge_step * (scale_from_deep(eye_depth(partials) + 1u) - 1.0);
    connection.weight = weigh_connection(
        eye.point, eye.vertex, partials, light_vertex, link.direction, f, arriving_light,
        eye_step, pdf_back_solid * eye.vertex.to_previous, pdf_eye, light_step, pdf_light,
    ).weight;
    return connection;
}
