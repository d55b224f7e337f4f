//! What is measured of the renderer: error against time, efficiency, rays; and the references that errors are against.

pub mod efficiency;
pub mod rays;
pub mod reference;
pub mod speed;
pub mod trade;
