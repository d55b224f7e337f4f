// Sums over the samples of each pixel since the host last took them.

struct FilmPixel {
    sum: vec3f,
    count: u32,
    sum_sq: vec3f,
    /// Samples left out because they were not finite.
    non_finite: u32,
}

@group(2) @binding(1) var<storage, read_write> film: array<FilmPixel>;
