// What a bent normal does with directions, so that it loses no light.
//
// The directions above a surface are a hemisphere about its geometric normal, those that its BSDF knows another one
// about the shading normal. What lies in one of them alone, a reflection that goes into the surface, an eye that the
// shading normal turns away from, would be lost. Here a map takes one hemisphere to the other: sampled directions are
// moved by it, evaluated ones by its inverse, and the densities of both by its Jacobian. It is one-to-one, so that all
// light that the BSDF reflects leaves the surface: Schuessler et al. 2017 ask as much of a microsurface, Cycles bends
// the normal of mirrors (`ensure_valid_specular_reflection`), which has no density. It treats all directions alike, eye's
// or light's: what passes straight through still does, and light paths find what eye paths find.
//
// In the plane of the normals, which are 2 a apart, with longitudes from the geometric one: the hemispheres are -90..90
// and 2 a - 90..2 a + 90 degrees. The map keeps latitudes, and longitudes but for a band at either end, 90 - a..90 and
// -90..3 a - 90. There it is a shear along the direction b where the band begins, v' = v -+ m (v x b) b, so that it is
// continuous with derivative 1, scaled back to the length of v. With m = 2 cos a / sin 3 a it takes the end of one
// hemisphere to that of the other, and the derivative of the longitude is |v|^2 / |v'|^2.

/// Squared sine of the angle below which normals are the same: f32 has few digits of what is left.
const MIN_BEND_SQ: f32 = 0x1p-20;

/// Both normals of a point, as far as directions are moved by them.
struct Bend {
    /// Unit vectors in the plane of both normals: across the geometric one, on the shading one's side, and across the
    /// shading one, on the geometric one's side.
    across_geometric: vec3f,
    across_shading: vec3f,
    /// Cosine and sine of a; the sine 0 for normals that are the same.
    half: vec2f,
}

/// A moved direction, and solid angle there for solid angle here.
struct Moved {
    world: vec3f,
    jacobian: f32,
}

/// Unit normals on the same side.
fn bend_between(shading: vec3f, geometric: vec3f) -> Bend {
    var bend: Bend;
    let cosine = dot(shading, geometric);
    let apart = shading - cosine * geometric;
    let sine_sq = dot(apart, apart);
    if sine_sq > MIN_BEND_SQ {
        let sine = sqrt(sine_sq);
        let half_cos = sqrt(0.5 + 0.5 * cosine);
        bend.across_geometric = apart / sine;
        bend.across_shading = normalize(geometric - cosine * shading);
        bend.half = vec2f(half_cos, 0.5 * sine / half_cos);
    }
    return bend;
}

/// `side`: 1 for the side of the normals, -1 for the other. `forward`: from the world to the BSDF.
fn moved(
    bend: Bend, shading: vec3f, geometric: vec3f, world: vec3f, side: f32, forward: bool,
) -> Moved {
    let along = side * vec2f(dot(world, geometric), dot(world, shading));
    let across = side * vec2f(dot(world, bend.across_geometric), dot(world, bend.across_shading));
    // v x b for the band at either end: the second is the first with the normals exchanged, and run backwards.
    let beyond = bend.half.y * across - bend.half.x * along;
    let leaning = beyond.x > 0.0;
    let excess = max(beyond.x, beyond.y);
    if bend.half.y == 0.0 || excess <= 0.0 {
        return Moved(world, 1.0);
    }
    let pole = select(shading, geometric, leaning);
    let pole_across = select(bend.across_shading, bend.across_geometric, leaning);
    let v = select(vec2f(along.y, across.y), vec2f(along.x, across.x), leaning);
    let sine_3 = bend.half.y * (3.0 - 4.0 * bend.half.y * bend.half.y);
    let shear = 2.0 * bend.half.x * excess / sine_3;
    let sheared = v + select(shear, -shear, forward == leaning) * bend.half.yx;
    let jacobian = dot(v, v) / dot(sheared, sheared);
    let delta = sheared * sqrt(jacobian) - v;
    return Moved(world + side * (delta.x * pole + delta.y * pole_across), jacobian);
}
