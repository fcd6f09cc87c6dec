//! Triangle connectivity: what it promises, and that nothing unsound gets past it.

mod connectivity;
mod faults;
mod orient;
mod shapes;
