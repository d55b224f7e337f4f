// Drawing from the integer alias tables that `math::alias` builds. Probabilities are exact: an entry of c units
// is drawn with probability c / (n 2^32), to within 2^-63.

/// Where a draw landed: a slot below n, and the level inside it, in units of 2^-32 of the slot.
struct AliasDraw {
    slot: u32,
    level: u32,
}

/// High word of the 64-bit product.
fn mul_high(a: u32, b: u32) -> u32 {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let middle = a_high * b_low + ((a_low * b_low) >> 16u);
    let middle_low = a_low * b_high + (middle & 0xffffu);
    return a_high * b_high + (middle >> 16u) + (middle_low >> 16u);
}

/// Slot and level from two random words: the upper 64 bits of the 96-bit product of the 64-bit fraction
/// `words` and `n`. (The slot from one word alone would leave slots unequal by n 2^-32.) `n` is at least 1.
fn alias_draw(words: vec2u, n: u32) -> AliasDraw {
    let high_low = words.x * n;
    let level = high_low + mul_high(words.y, n);
    let carry = select(0u, 1u, level < high_low);
    return AliasDraw(mul_high(words.x, n) + carry, level);
}

/// The entry drawn, from what the table holds at `draw.slot`. A full slot aliases to itself.
fn alias_pick(draw: AliasDraw, threshold: u32, alias_index: u32) -> u32 {
    return select(alias_index, draw.slot, draw.level < threshold);
}
