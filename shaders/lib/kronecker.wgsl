// Kronecker sequences: point i is a shift plus i times these steps, in units of 2^-32 and modulo one. The steps are the
// powers of 1 / x, x the positive solution of x^(d + 1) = x + 1 for d dimensions (Roberts 2018, the R_d sequence).

const KRONECKER_6 = array<u32, 6>(
    0xe60e2b72u, 0xcebd76dau, 0xb9c9aa3au, 0xa6f5777fu, 0x9609c71fu, 0x86d516e5u,
);
const KRONECKER_7 = array<u32, 7>(
    0xe95e1dd1u, 0xd4bc74e1u, 0xc1edbc5bu, 0xb0c8ac51u, 0xa127a31cu, 0x92e852c8u, 0x85eb75c3u,
);
