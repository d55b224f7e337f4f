// Points that lie well apart: point i is a shift plus i times these steps, in units of 2^-32 and modulo one.

/// For any number of points, a Kronecker sequence. The steps are the powers of 1 / x, x the positive solution of
/// x^7 = x + 1 (Roberts 2018, the R_6 sequence).
const KRONECKER_6 = array<u32, 6>(
    0xe60e2b72u, 0xcebd76dau, 0xb9c9aa3au, 0xa6f5777fu, 0x9609c71fu, 0x86d516e5u,
);
/// For the eight points of a group, a lattice: steps of odd eighths, so that each number alone visits every eighth once.
const LATTICE_8 = array<u32, 10>(
    0x20000000u, 0x60000000u, 0x20000000u, 0x60000000u, 0xa0000000u, 0x60000000u, 0x20000000u, 0xe0000000u, 0x60000000u,
    0x20000000u,
);
