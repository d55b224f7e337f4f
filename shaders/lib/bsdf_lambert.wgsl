#import lib/sampling
#import lib/surface

// The BSDF where every surface scatters by Lambert's law alone: lib/bsdf has the contract.

fn bsdf_evaluate(s: Surface, w_from: vec3f, w_to: vec3f, from_eye: bool) -> BsdfValue {
    var value: BsdfValue;
    if same_side(w_from, w_to) {
        value.f = s.base_color * INV_PI;
        value.pdf_solid = cosine_hemisphere_pdf_solid(abs(w_to.z));
#if bidirectional
        value.pdf_back_solid = cosine_hemisphere_pdf_solid(abs(w_from.z));
#endif
    }
    return value;
}

/// As `bsdf_sample`, the weight and any density but 0 left to `bsdf_evaluate`.
fn bsdf_sample_direction(s: Surface, w_from: vec3f, u: vec3f, from_eye: bool) -> BsdfSample {
    var sample: BsdfSample;
    let w = sample_cosine_hemisphere(u.xy);
    if same_side(w, facing(w_from, w_from)) && any(s.base_color > vec3f(0.0)) {
        sample.w = facing(w, w_from);
        sample.pdf_solid = 1.0;
    }
    return sample;
}
