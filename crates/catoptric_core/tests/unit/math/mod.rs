//! Numbers.

mod lanes;
mod portable;
mod random;
mod roots;
