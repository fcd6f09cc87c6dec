//! What a remeshed cage must be, over many surfaces and curves.

#![allow(clippy::print_stdout, reason = "the tables are for reading")]

mod borders;
mod bores;
mod closed;
mod crossings;
mod draw;
mod judge;
mod others;
mod placed;
mod refusals;
mod rims;
mod shapes;
pub(crate) mod support;
mod sweep;
