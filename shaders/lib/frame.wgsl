// Local frames: z is the normal.

struct Frame {
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
}

/// A right-handed orthonormal frame about a unit normal, continuous but where normal.z changes sign:
/// Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017, listing 3.
fn frame_from_normal(normal: vec3f) -> Frame {
    let side = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return Frame(
        vec3f(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3f(b, side + normal.y * normal.y * a, -normal.y),
        normal,
    );
}

fn to_local(frame: Frame, world: vec3f) -> vec3f {
    return vec3f(dot(world, frame.tangent), dot(world, frame.bitangent), dot(world, frame.normal));
}

fn to_world(frame: Frame, local: vec3f) -> vec3f {
    return local.x * frame.tangent + local.y * frame.bitangent + local.z * frame.normal;
}
