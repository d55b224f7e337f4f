//! The host side of `shaders/lib`: random numbers, alias tables, frames, colour. The functions there mirror the
//! shader functions of the same names; a test compares them. Beside it the statistics and the curves of
//! measurements.

pub mod alias;
pub mod color;
pub mod curve;
pub mod cutpoints;
pub mod date;
pub mod equal_area;
mod error;
pub mod exact;
pub mod fnv;
pub mod frame;
pub mod ggx_albedo;
pub mod kd_tree;
pub mod rng;
pub mod sampling;
pub mod scale;
pub mod shared_exponent;
pub mod statistics;

pub use error::MathError;

/// True unless x is an infinity or a NaN; mirrors the test of bits that the shaders use.
pub fn is_finite(x: f32) -> bool {
    x.to_bits() & 0x7f80_0000 != 0x7f80_0000
}
