//! Units of bakes and their files.

mod stored;
mod table;
