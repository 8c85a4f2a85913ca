//! The picture that all methods are measured against: our own reference's, or another program's.

use crate::args::{CompareArgs, DisplayArgs};
use crate::commands::diff::{as_png, is_linear};
use crate::commands::display::Display;
use crate::drawing::{Drawing, Shot};
use crate::failure::Failure;
use crate::stats::{ErrorReport, Stats};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::metrics::Comparison;
use catoptric::picture;
use std::path::Path;

/// 8-bit values from which on a pixel is lit.
const LIT: u8 = 8;
/// A picture that is black in a larger share of the lit pixels cannot be used.
const MOST_BLACK: f64 = 0.5;

/// The picture that all methods are measured against.
pub(super) struct Truth {
    /// As it is compared, linear.
    picture: Framebuffer,
    /// As it is shown.
    pub(super) shown: Framebuffer,
    /// True if it has 8 bits: others are rounded and clamped as it is.
    is_rounded: bool,
    /// Exposure and tone of all pictures.
    pub(super) display: Display,
    /// The pixels that show a reflector or lens.
    mask: Vec<bool>,
    /// Our own reference's run.
    pub(super) own: Option<Stats>,
    /// The mean FLIP, where methods are ranked, of this picture with black there.
    pub(super) error_of_nothing: Option<f64>,
}

/// Another program's picture, as it was read.
pub(super) struct OtherPicture {
    picture: Framebuffer,
    /// True if it holds radiance.
    is_linear: bool,
}

impl OtherPicture {
    /// Reads the picture of `--reference`, which must have the size of the methods' pictures and finite values.
    pub(super) fn read(path: &Path, args: &CompareArgs) -> Result<Self, Failure> {
        let (picture, is_linear) = (picture::read(path)?, is_linear(path)?);
        let (name, [width, height]) = (path.display(), args.view.size);
        let (own_width, own_height) = (picture.width, picture.height);
        if [own_width, own_height] != [width, height] {
            return Err(Failure::input(format!(
                "--reference {name}: has {own_width}x{own_height} pixels, the methods' pictures have {width}x{height}; \
                 give --size {own_width}x{own_height}, or another picture"
            )));
        }
        if let Some(at) = picture.pixels.iter().position(|pixel| !pixel[..3].iter().all(|value| value.is_finite())) {
            let (x, y) = (at % own_width as usize, at / own_width as usize);
            return Err(Failure::input(format!(
                "--reference {name}: the pixel at {x}, {y} is not finite, and nothing can be measured against it"
            )));
        }
        if !is_linear && Display::given(&args.display).is_none() {
            return Err(Failure::usage(format!(
                "--exposure auto: --reference {name} has 8 bits and an exposure already; give that in stops"
            )));
        }
        Ok(Self { picture, is_linear })
    }
}

impl Truth {
    /// From a drawing of our own reference.
    pub(super) fn of_drawing(args: &DisplayArgs, drawing: &Drawing, stats: Stats) -> Result<Self, Failure> {
        let display = Display::new(args, &drawing.scene, &drawing.view, &drawing.picture);
        let mask = specular_mask(&drawing.scene, &drawing.view);
        let (picture, shown) = (display.exposed(&drawing.picture), display.of(&drawing.picture));
        Self { picture, shown, is_rounded: false, display, mask, own: Some(stats), error_of_nothing: None }.weighed()
    }

    /// From another program's picture of the last frame's view.
    pub(super) fn of_file(args: &DisplayArgs, other: OtherPicture, shot: &Shot<'_>) -> Result<Self, Failure> {
        let OtherPicture { picture, is_linear } = other;
        let last = shot.sequence.frames().last().unwrap_or_default();
        let scene = shot.scene_of_frame(last)?;
        let view = shot.frame_view(&scene, last)?;
        let mask = specular_mask(&scene, &view);
        let given = Display::given(args).filter(|_| !is_linear);
        let display = given.unwrap_or_else(|| Display::new(args, &scene, &view, &picture));
        let (picture, shown) = match is_linear {
            true => (display.exposed(&picture), display.of(&picture)),
            false => (picture.clone(), picture),
        };
        Self { picture, shown, is_rounded: !is_linear, display, mask, own: None, error_of_nothing: None }.weighed()
    }

    /// With the error of drawing nothing.
    fn weighed(mut self) -> Result<Self, Failure> {
        let mut nothing = self.picture.clone();
        for (pixel, is_ranked) in nothing.pixels.iter_mut().zip(self.ranked()) {
            if is_ranked {
                *pixel = [0.0, 0.0, 0.0, 1.0];
            }
        }
        let comparison = Comparison::new(&nothing, &self.picture)?;
        let error = comparison.masked(&self.ranked().collect::<Vec<_>>())?;
        self.error_of_nothing = error.map(|error| error.flip_mean);
        Ok(self)
    }

    /// The number of pixels that show a reflector or lens.
    pub(super) fn reflector_pixels(&self) -> usize {
        self.mask.iter().filter(|set| **set).count()
    }

    /// The pixels by which methods are ranked: those that show reflectors or lenses if there are any, else all.
    fn ranked(&self) -> impl Iterator<Item = bool> {
        let is_any = self.mask.contains(&true);
        self.mask.iter().map(move |is_set| *is_set || !is_any)
    }

    /// The comparison of a method's picture, and its errors but for projections.
    pub(super) fn compare(&self, picture: &Framebuffer) -> Result<(Comparison, ErrorReport), Failure> {
        let compared = match self.is_rounded {
            true => as_png(&self.display.of(picture)),
            false => self.display.exposed(picture),
        };
        self.errors(&compared)
    }

    /// The reference's own errors: none.
    pub(super) fn own_errors(&self) -> Result<ErrorReport, Failure> {
        self.errors(&self.picture).map(|(_, error)| error)
    }

    fn errors(&self, compared: &Framebuffer) -> Result<(Comparison, ErrorReport), Failure> {
        let comparison = Comparison::new(compared, &self.picture)?;
        let (image, reflector) = (comparison.whole(), comparison.masked(&self.mask)?);
        Ok((comparison, ErrorReport { image, reflector, projection_px: None }))
    }

    /// Why a picture cannot be used, by what it shows and its mean FLIP where methods are ranked.
    pub(super) fn fault(&self, shown: &Framebuffer, error: Option<f64>) -> Option<&'static str> {
        let (own, truth) = (shown.to_srgb8(), self.shown.to_srgb8());
        let brightest = |pixel: &[u8]| pixel.iter().copied().max().unwrap_or_default();
        let pixels = own.chunks_exact(3).zip(truth.chunks_exact(3)).zip(self.ranked());
        let lit = pixels.filter(|((_, truth), is_ranked)| *is_ranked && brightest(truth) >= LIT);
        let (lit, black) =
            lit.fold((0_u64, 0_u64), |(lit, black), ((own, _), _)| (lit + 1, black + u64::from(brightest(own) == 0)));
        if black as f64 > MOST_BLACK * lit as f64 {
            return Some("mostly black");
        }
        let is_worse = error.zip(self.error_of_nothing).is_some_and(|(own, nothing)| own >= nothing && own > 0.0);
        is_worse.then_some("worse than drawing nothing")
    }
}
