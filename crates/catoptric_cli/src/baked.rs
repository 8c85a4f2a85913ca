//! `--baked FILE`: what was precomputed, for the methods that it was precomputed for.

use crate::failure::Failure;
use catoptric_bake::Shelf;
use std::path::PathBuf;

/// Opens files, and checks them whole. The first of a method that fits is used.
pub(crate) fn open(paths: &[PathBuf]) -> Result<Shelf, Failure> {
    let mut shelf = Shelf::default();
    for path in paths.iter().rev() {
        shelf.open(path)?;
    }
    Ok(shelf)
}

/// Checks that each is of one of these methods.
pub(crate) fn check_methods(bakes: &Shelf, methods: &[&str]) -> Result<(), Failure> {
    for (name, file) in bakes.files() {
        let method = file.identity().method.as_str();
        if !methods.contains(&method) {
            let asked = methods.join(", ");
            return Err(Failure::input(format!("--baked {name}: is a bake of {method}, not of {asked}")));
        }
    }
    Ok(())
}
