// The equal-area map between directions and the unit square, +y in its centre, -y in its corners: a density in
// the square divided by 4 pi is a density per solid angle.
// Clarberg, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD, JGT 13(3), 2008, arranged as in pbrt-v4's
// EqualAreaSquareToSphere and EqualAreaSphereToSquare. Within 1e-6 of the f64 functions of math::equal_area.

/// Unit direction of a point of the square.
fn square_to_sphere(square: vec2f) -> vec3f {
    let p = 2.0 * square - 1.0;
    let q = abs(p);
    let signed_distance = 1.0 - (q.x + q.y);
    let r = 1.0 - abs(signed_distance);
    let turn = select((q.y - q.x) / max(r, 0x1p-100), 0.0, r == 0.0);
    // Cosine and sine of pi/4 turn, within 2e-9: WGSL promises its own to 2^-11 only.
    let t2 = turn * turn;
    let c = 1.0 + t2 * (-0.3084251352 + t2 * (0.01585432525 + t2 * (-0.0003259386144 + t2 * 3.529811345e-6)));
    let s = turn * (0.7853981526 + t2 * (-0.08074536745 + t2 * (0.002489872283 - t2 * 3.587742461e-5)));
    // The azimuth is pi/4 (turn + 1), mirrored into its quadrant.
    let azimuth = 0.7071067811865475 * vec2f(c - s, c + s);
    let r2 = r * r;
    let horizontal = azimuth * (r * sqrt(2.0 - r2));
    let mirrored = select(horizontal, -horizontal, p < vec2f(0.0));
    return vec3f(mirrored.x, select(1.0 - r2, r2 - 1.0, signed_distance < 0.0), -mirrored.y);
}

/// Point of the square, in [0, 1], of a unit direction.
fn sphere_to_square(direction: vec3f) -> vec2f {
    let a = abs(direction);
    // sqrt(1 - |y|) without its cancellation near the poles.
    let r = sqrt((a.x * a.x + a.z * a.z) / (1.0 + a.y));
    let high = max(a.x, a.z);
    let ratio = select(min(a.x, a.z) / max(high, 0x1p-100), 0.0, high == 0.0);
    let part = quarter_turns(ratio);
    let along = r * select(part, 1.0 - part, a.x < a.z);
    let upper = vec2f(r - along, along);
    let p = select(upper, 1.0 - upper.yx, direction.y < 0.0);
    let mirrored = select(p, -p, vec2f(direction.x, -direction.z) < vec2f(0.0));
    return clamp(0.5 * mirrored + 0.5, vec2f(0.0), vec2f(1.0));
}

/// 2/pi atan(x) for x in [0, 1], within 3e-8.
fn quarter_turns(x: f32) -> f32 {
    let x2 = x * x;
    let low = 0.6366193521 + x2 * (-0.2121845585 + x2 * (0.1269844632 - x2 * 0.08854799786));
    let high = 0.0613907165 + x2 * (-0.03560301431 + x2 * (0.01392356053 - x2 * 0.002582545581));
    return x * (low + x2 * x2 * x2 * x2 * high);
}
