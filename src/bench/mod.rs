//! What is measured of the renderer: error against time, efficiency, rays; and the references that errors are against.
//!
//! | module | idea |
//! |---|---|
//! | [`efficiency`] | 1 / (relMSE x time), from rounds in which each integrator renders once |
//! | [`trade`] | error against time: renders that are compared with a reference while they converge |
//! | [`reference`] | pictures to compare with, summed from independent passes |
//! | [`speed`] | how fast the device is at the moment, and a clock that allows for it |
//! | [`key`] | what a render's figures depend on, so that stored ones are found again |
//! | [`rays`] | rays per second |

pub mod efficiency;
pub mod key;
pub mod rays;
pub mod reference;
pub mod speed;
pub mod trade;
