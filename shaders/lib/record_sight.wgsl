#import lib/strategies
#import lib/traverse

// What a record sees.

/// What is hidden from a record may be seen from where it is asked: so much of its light counts. Su, Li, Wang's code has it.
const HIDDEN_SHARE: f32 = 0.02;

/// Share of the light along a link from a record's point that counts.
fn seen_share(point: SurfacePoint, link: Link, kind: u32) -> f32 {
    let shadow = link_ray(point, link, kind);
#if alpha
    // What is half there or more hides.
    alpha_word = 0x80000000u;
#endif
    let hit = trace(shadow.origin, shadow.direction, shadow.t_max);
    return select(HIDDEN_SHARE, 1.0, hit.triangle == NO_TRIANGLE);
}
