//! From drawn frames to files.

use super::passes::{Passes, cut_out, straight};
use super::plan::Plan;
use crate::args::RenderArgs;
use crate::commands::display::Display;
use crate::drawing::Drawing;
use crate::failure::Failure;
use crate::parse::FileOrStream;
use catoptric::framebuffer::Framebuffer;
use catoptric::output;
use catoptric::picture::{self, Channel, ChannelValues, PictureFormat};
use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};
use std::ops::ControlFlow;

/// Writes the pictures of a command.
pub(super) struct Pictures<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) plan: &'a Plan,
    pub(super) passes: Passes<'a>,
    /// The display of the first frame, for all of them.
    pub(super) display: Option<Display>,
}

impl Pictures<'_> {
    /// Writes a frame, counted from 0, and its mask. Tells whether anyone wants more of them.
    pub(super) fn write(&mut self, frame: u32, drawing: &Drawing) -> Result<ControlFlow<()>, Failure> {
        let bytes = self.encoded(drawing)?;
        if let Some(output) = self.plan.mask(self.args, frame) {
            let shares = self.passes.mask(drawing);
            let ([width, height], shares) = self.part_of(drawing, shares);
            let format = output.path().and_then(PictureFormat::from_path).unwrap_or(PictureFormat::Png);
            output.write(|writer| writer.write_all(&picture::encode_mask(format, width, height, &shares)?))?;
        }
        let output = self.plan.picture(self.args, frame);
        if self.plan.writes_all && output == FileOrStream::Stream {
            return match output::write_stream(&mut io::stdout().lock(), |writer| writer.write_all(&bytes)) {
                // The reader has had enough.
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(ControlFlow::Break(())),
                Err(error) => Err(Failure::input(format!("standard output: cannot write to it: {error}"))),
                Ok(()) => Ok(ControlFlow::Continue(())),
            };
        }
        output.write(|writer| writer.write_all(&bytes))?;
        Ok(ControlFlow::Continue(()))
    }

    fn encoded(&mut self, drawing: &Drawing) -> Result<Vec<u8>, Failure> {
        let (args, format) = (&self.args.picture, self.plan.format);
        let mut picture = Cow::Borrowed(&drawing.picture);
        if args.transparent {
            picture = Cow::Owned(cut_out(&drawing.picture, &self.passes.coverage(drawing)?));
        }
        let fail = |error: io::Error| Failure::input(format!("{}: {error}", self.args.output.output_name()));
        if format.is_linear() {
            let layers = if args.layers { Some(self.passes.layers(drawing)?) } else { None };
            let (channels, about) = layers.unzip();
            let channels =
                channels.unwrap_or_default().into_iter().map(|channel| self.part_of_channel(drawing, channel));
            let half = format == PictureFormat::ExrHalf;
            return picture::encode_layers(&self.part(&picture), half, channels.collect(), about.as_deref())
                .map_err(fail);
        }
        let display = *self
            .display
            .get_or_insert_with(|| Display::new(&self.args.display, &drawing.scene, &drawing.view, &drawing.picture));
        if !args.transparent {
            return picture::encode(format, &self.part(&display.of(&picture))).map_err(fail);
        }
        picture::encode_with_alpha(format, &self.part(&display.of(&straight(&picture)))).map_err(fail)
    }

    /// The part of a picture that is to be written.
    fn part<'p>(&self, picture: &'p Framebuffer) -> Cow<'p, Framebuffer> {
        match &self.args.picture.region {
            None => Cow::Borrowed(picture),
            Some(region) => {
                let [width, height] = region.size;
                Cow::Owned(Framebuffer::of_pixels(width, height, region.of(&picture.pixels, picture.width)))
            }
        }
    }

    /// The same of a value a pixel, with its size.
    fn part_of<T: Copy>(&self, drawing: &Drawing, values: Vec<T>) -> ([u32; 2], Vec<T>) {
        let (width, height) = (drawing.view.width, drawing.view.height);
        match &self.args.picture.region {
            None => ([width, height], values),
            Some(region) => (region.size, region.of(&values, width)),
        }
    }

    fn part_of_channel(&self, drawing: &Drawing, Channel { name, values }: Channel) -> Channel {
        let values = match values {
            ChannelValues::Light(values) => ChannelValues::Light(self.part_of(drawing, values).1),
            ChannelValues::Float(values) => ChannelValues::Float(self.part_of(drawing, values).1),
            ChannelValues::Number(values) => ChannelValues::Number(self.part_of(drawing, values).1),
        };
        Channel { name, values }
    }
}
