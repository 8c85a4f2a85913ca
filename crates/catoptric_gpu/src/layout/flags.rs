//! Bits by their names.

macro_rules! flags {
    ($($(#[$doc:meta])* $name:ident = $bit:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = 1 << $bit;)*
        /// All of them with their names in shaders.
        pub const ALL: &[(&str, u32)] = &[$((stringify!($name), $name)),*];
    };
}
