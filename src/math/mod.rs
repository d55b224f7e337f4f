//! The host side of `shaders/lib`: random numbers, alias tables, frames, colour.
