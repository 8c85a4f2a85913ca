//! Slabs and sides of light fields, and transfer of rays.

mod layout;
mod slabs;
mod transfer;
