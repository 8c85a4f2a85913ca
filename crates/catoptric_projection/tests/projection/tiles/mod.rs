//! Tiles of reflectors: multiperspective rasterisation, and the choice that uses it.

mod auto;
mod multiperspective;
