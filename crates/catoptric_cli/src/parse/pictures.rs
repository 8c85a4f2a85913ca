//! Frames, the names of their files, and parts of pictures.

use std::path::{Path, PathBuf};

/// The most frames of a sequence.
const MOST_FRAMES: u32 = 100_000;
/// The largest number of a frame.
const LAST_FRAME: u32 = 1_000_000;
/// The most digits that a pattern can stand for.
const MOST_DIGITS: usize = 9;

/// The frames that `--frames` names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FramesWanted {
    /// This many frames, from the first.
    Count(u32),
    /// From one number to another, both included, counted from 1.
    Range(u32, u32),
}

pub(crate) fn frames_wanted(text: &str) -> Result<FramesWanted, String> {
    let whole = |text: &str| text.trim().parse::<u32>().map_err(|_| format!("`{text}` is not a whole number"));
    let Some((first, last)) = text.split_once("..") else {
        return match whole(text)? {
            count @ 1..=MOST_FRAMES => Ok(FramesWanted::Count(count)),
            _ => Err(format!("it must be in 1..={MOST_FRAMES}, or a range such as 1..240")),
        };
    };
    match [whole(first)?, whole(last)?] {
        [first, last] if first == 0 || last > LAST_FRAME => {
            Err(format!("frames are numbered from 1 to {LAST_FRAME}: {first}..{last}"))
        }
        [first, last] if first > last => Err(format!("the first frame comes after the last: {first}..{last}")),
        [first, last] if last - first >= MOST_FRAMES => Err(format!("more than {MOST_FRAMES} frames")),
        [first, last] => Ok(FramesWanted::Range(first, last)),
    }
}

pub(crate) fn frames_per_second(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(count) if (0.001..=10_000.0).contains(&count) => Ok(count),
        _ => Err("it must be a number from 0.001 to 10000".into()),
    }
}

/// The name of a frame's file with a place for its number: `frame-####.png` or `frame-%04d.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NamePattern {
    whole: PathBuf,
    before: String,
    /// Digits at least.
    digits: usize,
    after: String,
}

impl NamePattern {
    /// The pattern in a file's name, if there is one: two `#` or more, or `%d` with or without a number of digits.
    pub(crate) fn of(path: &Path) -> Result<Option<Self>, String> {
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return Ok(None) };
        let mut places = hashes(name);
        places.extend(percent(name));
        match places[..] {
            [] => Ok(None),
            [(start, end, digits)] if digits <= MOST_DIGITS => {
                let (before, after) = (name[..start].into(), name[end..].into());
                Ok(Some(Self { whole: path.into(), before, digits, after }))
            }
            [_] => Err(format!("a pattern stands for {MOST_DIGITS} digits at most")),
            _ => Err(format!("`{name}` has more than one pattern for the number of a frame")),
        }
    }

    /// The file of a frame.
    pub(crate) fn path(&self, number: u32) -> PathBuf {
        let Self { whole, before, digits, after } = self;
        whole.with_file_name(format!("{before}{number:0digits$}{after}"))
    }
}

/// The beginnings, ends and digits of runs of `#`.
fn hashes(name: &str) -> Vec<(usize, usize, usize)> {
    let mut runs: Vec<(usize, usize, usize)> = Vec::new();
    for (at, _) in name.match_indices('#') {
        match runs.last_mut() {
            Some((_, end, digits)) if *end == at => (*end, *digits) = (at + 1, *digits + 1),
            _ => runs.push((at, at + 1, 1)),
        }
    }
    runs.retain(|(_, _, digits)| *digits > 1);
    runs
}

/// The same of numbers as in C: `%d`, `%4d`, `%04d`, where no letter follows that would make it a word.
fn percent(name: &str) -> Vec<(usize, usize, usize)> {
    let place = |(at, _): (usize, &str)| {
        let rest = &name[at + 1..];
        let length = rest.find(|letter: char| !letter.is_ascii_digit())?;
        let after = rest[length..].strip_prefix('d')?;
        (!after.starts_with(char::is_alphabetic)).then_some(())?;
        let digits = if length == 0 { 1 } else { rest[..length].parse().ok()? };
        Some((at, at + length + 2, digits))
    };
    name.match_indices('%').filter_map(place).collect()
}

/// A part of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    /// Left and top.
    pub(crate) corner: [u32; 2],
    /// Width and height, not 0.
    pub(crate) size: [u32; 2],
}

impl Region {
    /// The values of its pixels, from those of a picture of this width that it lies in; rows from the top.
    pub(crate) fn of<T: Copy>(&self, values: &[T], width: u32) -> Vec<T> {
        let rows = values.chunks_exact(width as usize).skip(self.corner[1] as usize).take(self.size[1] as usize);
        let left = self.corner[0] as usize;
        rows.flat_map(|row| &row[left..left + self.size[0] as usize]).copied().collect()
    }

    /// Returns true if it lies within a picture.
    pub(crate) fn is_within(&self, size: [u32; 2]) -> bool {
        (0..2).all(|axis| u64::from(self.corner[axis]) + u64::from(self.size[axis]) <= u64::from(size[axis]))
    }
}

pub(crate) fn region(text: &str) -> Result<Region, String> {
    let whole = |part: &str| part.trim().parse::<u32>().map_err(|_| format!("`{part}` is not a whole number"));
    match text.split(',').map(whole).collect::<Result<Vec<u32>, String>>()?[..] {
        [_, _, width, height] if width == 0 || height == 0 => Err("its width and height must be 1 at least".into()),
        [x, y, width, height] => Ok(Region { corner: [x, y], size: [width, height] }),
        _ => Err("write it as X,Y,W,H, such as 640,0,320,240".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_ranges() {
        assert_eq!(frames_wanted("240"), Ok(FramesWanted::Count(240)));
        assert_eq!(frames_wanted("3..7"), Ok(FramesWanted::Range(3, 7)));
        for wrong in ["0", "100001", "0..4", "5..4", "1..", "..4", "a..b", "1..1000001", "1..200000", "-1..4", ""] {
            assert!(frames_wanted(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn patterns_are_hashes_or_as_in_c() {
        let name = |pattern: &str, number| {
            let pattern = NamePattern::of(Path::new(pattern)).unwrap().unwrap();
            pattern.path(number).to_str().unwrap().to_owned()
        };
        assert_eq!(name("out/frame-####.png", 7), "out/frame-0007.png");
        assert_eq!(name("%03d.exr", 12), "012.exr");
        assert_eq!(name("a%d.png", 12), "a12.png");
        assert_eq!(name("a##.png", 1234), "a1234.png", "numbers are never cut");
        for plain in ["a.png", "take#3.png", "100%.png", "fo##lder/a.png", "50%done.png"] {
            assert_eq!(NamePattern::of(Path::new(plain)), Ok(None), "{plain}");
        }
        for wrong in ["a##b##.png", "##%d.png", "##########.png", "%99d.png"] {
            assert!(NamePattern::of(Path::new(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn regions_are_parts_of_rows() {
        let part = region("1, 1,2,2").unwrap();
        assert_eq!(part.of(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], 4), [5, 6, 9, 10]);
        assert!(part.is_within([3, 3]) && !part.is_within([2, 3]) && !part.is_within([3, 2]));
        assert!(!Region { corner: [u32::MAX; 2], size: [1; 2] }.is_within([16, 16]));
        for wrong in ["1,2,3", "1,2,0,4", "-1,0,1,1", "a,0,1,1", "1,2,3,4,5", ""] {
            assert!(region(wrong).is_err(), "{wrong}");
        }
    }
}
