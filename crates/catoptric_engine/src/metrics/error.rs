//! Pictures that cannot be compared.

use catoptric_core::framebuffer::Framebuffer;

/// Pictures that cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MetricError {
    /// The two pictures differ in size.
    #[error(
        "pictures of {}x{} and {}x{} pixels cannot be compared: both must have the same size",
        test.0, test.1, reference.0, reference.1
    )]
    Size {
        /// Width and height of the picture under test.
        test: (u32, u32),
        /// Width and height of the reference.
        reference: (u32, u32),
    },
    /// The picture's pixels or the mask do not match its size.
    #[error("{what} holds {found} values where the picture has {expected} pixels")]
    Length {
        /// The array at fault.
        what: &'static str,
        /// The number of values it holds.
        found: usize,
        /// The number it must hold.
        expected: usize,
    },
}

pub(super) fn check(test: &Framebuffer, reference: &Framebuffer) -> Result<(), MetricError> {
    let (test_size, reference_size) = ((test.width, test.height), (reference.width, reference.height));
    if test_size != reference_size {
        return Err(MetricError::Size { test: test_size, reference: reference_size });
    }
    let expected = test.width as usize * test.height as usize;
    for (what, picture) in [("the picture under test", test), ("the reference", reference)] {
        if picture.pixels.len() != expected {
            return Err(MetricError::Length { what, found: picture.pixels.len(), expected });
        }
    }
    Ok(())
}
