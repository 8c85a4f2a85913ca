//! Rows and grids of one thing: the keys `count` and `step`.

use super::keys::{Keys, Located, Text};
use catoptric_core::error::SceneError;
use glam::DVec3;

/// The places of all copies, about that of the first.
pub(super) struct Copies {
    /// The ways from the first one, x changing fastest.
    pub(super) offsets: Vec<DVec3>,
}

impl Copies {
    /// Takes `count` and `step` from a table, for so many copies at most.
    pub(super) fn read(text: Text<'_>, table: &mut Keys<'_, '_>, most: f64) -> Result<Self, SceneError> {
        let (count, step) = (table.one_or_more("count", 3)?, table.numbers::<3>("step")?);
        let (count, step) = match (count, step) {
            (None, None) => return Ok(Self { offsets: vec![DVec3::ZERO] }),
            (Some(count), Some(step)) => (count, super::places::exact_point(text, &table.field("step"), step)?),
            (None, Some(_)) => return Err(table.missing("count", "missing; `step` needs `count`, such as 5")),
            (Some(_), None) => return Err(table.missing("step", "missing; `count` needs `step = [x, y, z]`")),
        };
        let wrong = |problem: String| Err(table.wrong("count", count.begin, problem));
        if count.value.len() == 2 {
            return wrong("must be one number, or three in brackets: along x, y and z".into());
        }
        if count.value.iter().any(|number| number.fract() != 0.0 || *number < 1.0)
            || count.value.iter().product::<f64>() > most
        {
            return wrong(format!("{:?}; allowed are whole numbers from 1 to {most} in all", count.value));
        }
        Ok(Self { offsets: offsets(&count, step) })
    }

    /// The name of a copy.
    pub(super) fn name(&self, name: &str, index: usize) -> String {
        if self.offsets.len() == 1 { name.into() } else { format!("{name} {index}") }
    }
}

/// Along the step for one number, else on a grid along the axes.
fn offsets(count: &Located<Vec<f64>>, step: DVec3) -> Vec<DVec3> {
    let counts: Vec<u32> = count.value.iter().map(|number| *number as u32).collect();
    match counts[..] {
        [x, y, z] => {
            let line = move |z: u32, y: u32| (0..x).map(move |x| step * DVec3::new(x.into(), y.into(), z.into()));
            (0..z).flat_map(|z| (0..y).flat_map(move |y| line(z, y))).collect()
        }
        _ => (0..counts[0]).map(|index| step * f64::from(index)).collect(),
    }
}
