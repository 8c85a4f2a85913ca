//! The program `catoptric`.

fn main() {}
