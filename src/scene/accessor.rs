//! accessor
