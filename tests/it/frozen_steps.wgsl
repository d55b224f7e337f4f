// A step from a vertex along a given direction, with the densities that the kernels have for it: frozen_paths.wgsl.

struct Step {
    pdf_solid: f32,
    next: SubPath,
    /// f |cos| / density.
    weight: vec3f,
    /// Per solid angle, of the direction back.
    pdf_back_solid: f32,
}

fn is_delta(point: SurfacePoint) -> bool {
    return (materials[point.material].flags & MATERIAL_DELTA) != 0u;
}

/// Where a ray starts is off the surface by a little, so its direction is too, most of all on short edges: weights must
/// follow from the positions alone.
fn turned_vertex(
    point: SurfacePoint, direction: vec3f, pdf_solid: f32, previous: SubPath, scale: f32,
) -> PathVertex {
    var turned = direction;
    if (previous.flags & SUBPATH_INFINITE) == 0u {
        turned = normalize(direction + 0x1p-7 * point.world_ng.yzx);
    }
    return path_vertex(point, turned, pdf_solid, previous, scale);
}

fn step_along(point: SurfacePoint, vertex: PathVertex, direction: vec3f, from_eye: bool) -> Step {
    let surface = point_surface(point);
    let frame = point_frame(point);
    let survives = path_survival(surface, vertex);
    if is_delta(point) {
        let reflects = (dot(direction, point.world_ng) > 0.0) == (dot(vertex.world_from, point.world_ng) > 0.0);
        let u = vec3f(0.5, 0.5, select(0.99999994, 0.0, reflects));
        let sample = shading_sample_direction(surface, frame, vertex.world_from, u, from_eye);
        let event = sample.pdf_solid * survives;
        let back = event * delta_measure(surface, frame, vertex.world_from);
        return Step(
            event * delta_measure(surface, frame, direction),
            next_sub_path(point, vertex, true, back),
            sample.weight / survives,
            back,
        );
    }
    let value = shading_evaluate(surface, frame, vertex.world_from, direction, from_eye);
    return Step(
        value.pdf_solid * survives,
        next_sub_path(point, vertex, false, value.pdf_back_solid * survives),
        value.f * (abs(dot(direction, point.world_ng)) / value.pdf_solid / survives),
        value.pdf_back_solid * survives,
    );
}
