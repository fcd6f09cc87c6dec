//! What a remeshed cage must be, over many surfaces and curves.

mod shapes;
mod support;
mod draw;
mod bores;
mod judge;
