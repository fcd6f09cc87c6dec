//! What happens: selvedge's stages, each a pure kernel and the thin system that runs it.
