// Sums over the samples of each pixel since the host last took them. Samples come in groups of SAMPLES_A_GROUP: those of
// a group lie well apart (lib/path_key) and may share light paths, so that only whole groups are independent.

struct FilmPixel {
    sum: vec3f,
    count: u32,
    /// Of each group its sum squared over its samples; in units of -2^-120 where it is negative.
    sum_sq: vec3f,
    /// Samples left out because they were not finite.
    non_finite: u32,
    /// The group that is not whole yet: not in the sums above.
    open: vec3f,
    /// Its samples in the low 8 bits; above them the whole groups.
    open_groups: u32,
}

@group(2) @binding(1) var<storage, read_write> film: array<FilmPixel>;
