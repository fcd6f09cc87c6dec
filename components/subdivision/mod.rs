//! Combined Loop subdivision: masks, borders, details, evaluation.

pub mod masks;
