//! The window that shows a picture while it renders, and moves its camera.

pub mod controls;
