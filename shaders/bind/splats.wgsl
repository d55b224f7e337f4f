// What light paths bring to the picture: for each channel of each pixel the low and the high word of lib/splat, and
// then how many contributions were lost to it.

#if splats_atomic
@group(2) @binding(3) var<storage, read_write> splats: array<atomic<u32>>;
#else
@group(2) @binding(3) var<storage, read_write> splats: array<u32>;
#endif

const SPLAT_WORDS: u32 = 7u;
const SPLAT_LOST: u32 = 6u;
