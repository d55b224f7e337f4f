#import lib/hit
#import lib/rng

// Masked and blended surfaces, decided while tracing. A blended surface is there with probability alpha: each
// crossing is an independent draw, so the picture is right on average, and no ray needs to be split.

/// A random word of the ray; set before `trace`.
var<private> alpha_word: u32;

/// True where the surface is there.
fn is_present(triangle: u32, b1: f32, b2: f32) -> bool {
    var point: SurfacePoint;
    point.triangle = triangle;
    point.b = vec3f(1.0 - b1 - b2, b1, b2);
    point.material = triangles[triangle].material_flags & TRIANGLE_MATERIAL;
    return uniform_from_word(pcg4d(vec4u(alpha_word, triangle, 0u, 0u)).x) < point_presence(point);
}
