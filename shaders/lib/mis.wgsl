// The balance heuristic over all strategies that could have made a path, by ratios: no product of densities is
// ever formed, so path length and scale do not matter.
//
// A path x_0 (camera) .. x_n (light) is made by the strategy of t eye vertices with density P_t:
//
//   t = n + 1   H pE(1) .. pE(n)                                   the eye path hits the light
//   2 <= t <= n pE(1) .. pE(t-1)  c(x_{t-1}, x_t)  pL(t) .. pL(n)  a connection
//   t = 1       M pL(1) .. pL(n)                                   the light path connects to the camera
//
// pE(i), pL(i): density per area of sampling x_i from the eye's or the light's side, roulette included. c: expected
// connections of one eye vertex to one given light vertex (1 for plain bidirectional path tracing; N / L for N uniform
// picks from a cache of L vertices a path, Davidovic et al. 2014), times a share that depends on t alone (lib/connections).
// H: the share of light that is hit. Shares are free: how far weights trust a strategy beside how often it is used. M:
// light paths of an iteration; pE(1) is per pixel.
//
// Beside a vertex v_k, k = 0 at the end of its sub-path, goes the ratio
//
//   ratio(v_k) = (ratio(v_{k-1}) pb(v_{k-2}) + c(v_{k-1}, v_{k-2})) / p(v_{k-1})
//
// where p is the density of a vertex from its own side and pb from the other: the sum over all strategies that make
// more of the path from the other side, over the density of this one, but for the last two factors, which wait for
// their directions. Delta vertices have c = 0; their densities are relative to Dirac's delta in the measure
// n^2 cos dw, which refraction preserves, so that the ratio of both directions is right.
// Veach 1997, section 10.2; recursion after van Antwerpen 2011.

/// The step of the ratio: `ratio` and `edge` c of the vertex, `pdf_back` pb of the one before it, `pdf` p of the vertex.
fn mis_step(ratio: f32, pdf_back: f32, edge: f32, pdf: f32) -> f32 {
    return (ratio * pdf_back + edge) / pdf;
}

/// Weight of a connection of density `edge`. Each side: its `mis_step`, and the density of its vertex as sampled from
/// the other end of the connection.
fn connection_weight(edge: f32, eye_step: f32, pdf_eye: f32, light_step: f32, pdf_light: f32) -> f32 {
    return edge / (edge + eye_step * pdf_eye + light_step * pdf_light);
}

/// The weight of a connection, and the density of all strategies that make the path, over those of its two sub-paths.
struct ConnectionWeight {
    weight: f32,
    density: f32,
}

/// Weight of an eye path that ends on a light: `scale`: H; `pdf_light` and `pdf_eye`: densities of the last vertex from
/// both sides; `pdf_previous`: density of the last but one, as emission samples it; `edge`: c of connecting the two.
fn hit_weight(
    scale: f32, edge: f32, ratio: f32, pdf_previous: f32, pdf_light: f32, pdf_eye: f32,
) -> f32 {
    return scale / (scale + (edge + ratio * pdf_previous) * (pdf_light / pdf_eye));
}
