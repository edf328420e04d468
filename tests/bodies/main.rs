//! Cloth and bodies, without an engine.

mod coupling;
mod fine;
mod whole_sheets;
