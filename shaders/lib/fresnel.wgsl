// Reflectances of smooth interfaces. `cos_theta`: cosine between a direction and the (micro)normal, in (0, 1].

fn pow5(x: f32) -> f32 {
    let x_sq = x * x;
    return x_sq * x_sq * x;
}

/// Schlick's approximation from f0 at normal incidence to f90 at grazing incidence.
fn fresnel_schlick(f0: vec3f, f90: f32, cos_theta: f32) -> vec3f {
    return mix(f0, vec3f(f90), pow5(max(1.0 - cos_theta, 0.0)));
}

/// sqrt(eta^2 - sin^2): eta times the cosine on the far side, or -1 under total internal reflection, which the
/// sign of the radicand tells. The form is exact at eta = 1, where it returns `cos_theta`.
fn refracted_cos(cos_theta: f32, eta: f32) -> f32 {
    let radicand = (eta - 1.0) * (eta + 1.0) + cos_theta * cos_theta;
    return select(-1.0, sqrt(max(radicand, 0.0)), radicand >= 0.0);
}

/// Fresnel's equations for unpolarised light between dielectrics, eta = n_far / n_near.
/// 1 - result is transmitted; 0 at eta = 1.
fn fresnel_dielectric(cos_theta: f32, eta: f32) -> f32 {
    let g = refracted_cos(cos_theta, eta);
    if g < 0.0 || cos_theta <= 0.0 {
        return 1.0;
    }
    let perpendicular = (cos_theta - g) / (cos_theta + g);
    let parallel = (eta * eta * cos_theta - g) / (eta * eta * cos_theta + g);
    return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

/// Reflectance of a thin pane: both interfaces and all bounces between them, r + (1-r)^2 r + ... = 2 r / (1 + r).
fn fresnel_thin(cos_theta: f32, eta: f32) -> f32 {
    let r = fresnel_dielectric(cos_theta, eta);
    return 2.0 * r / (1.0 + r);
}
