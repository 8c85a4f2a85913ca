//! Shards: which units one task of a cluster makes.

use crate::error::BakeError;
use std::fmt;
use std::str::FromStr;

/// The batches of units (most often one unit each) with `batch % count == index`. Results are per unit, so the number
/// of shards may change from run to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// Everything.
    pub const ALL: Self = Self { index: 0, count: 1 };

    /// A shard of `count`, counted from 0.
    ///
    /// # Errors
    /// [`BakeError::Shard`] unless `index < count`.
    pub fn new(index: u64, count: u64) -> Result<Self, BakeError> {
        Self::checked(index, count)
            .map_err(|problem| BakeError::Shard { place: format!("shard {index}/{count}"), problem })
    }

    fn checked(index: u64, count: u64) -> Result<Self, String> {
        match count.checked_sub(1) {
            None => Err("there must be at least one shard".into()),
            Some(last) if index > last => Err(format!("shards count from 0: 0/{count} to {last}/{count} are allowed")),
            Some(_) => Ok(Self { index, count }),
        }
    }

    /// The index of the shard, from 0.
    pub fn index(self) -> u64 {
        self.index
    }

    /// The number of shards.
    pub fn count(self) -> u64 {
        self.count
    }

    /// The shard's batches among those of a bake, in order.
    pub fn of<T>(self, batches: &[T]) -> impl Iterator<Item = &T> {
        // On machines of 32 bits a shard that no slice reaches has none, and no step is longer than a slice.
        let [index, count] = [self.index, self.count].map(|number| usize::try_from(number).unwrap_or(usize::MAX));
        batches.iter().skip(index).step_by(count)
    }

    /// The shard that a scheduler has given to this task, by its environment variables, which `lookup` reads:
    ///
    /// * Slurm's job arrays: `SLURM_ARRAY_TASK_ID`, `SLURM_ARRAY_TASK_COUNT`, `SLURM_ARRAY_TASK_MIN` and, where set,
    ///   `SLURM_ARRAY_TASK_STEP`. The array must not have gaps: tasks of `--array=3,7` cannot find out which of them
    ///   they are.
    /// * AWS Batch's array jobs: `AWS_BATCH_JOB_ARRAY_INDEX`, `AWS_BATCH_JOB_ARRAY_SIZE`.
    /// * Kubernetes' indexed jobs: `JOB_COMPLETION_INDEX`. Kubernetes does not pass their number, so the job must
    ///   set `CATOPTRIC_SHARDS` to its number of completions.
    ///
    /// # Errors
    /// [`BakeError::Shard`] where none of these is set, or one of them is no number or does not fit the others.
    pub fn from_environment(lookup: impl Fn(&str) -> Option<String>) -> Result<Self, BakeError> {
        let number = |name: &'static str, default: Option<u64>| -> Result<u64, BakeError> {
            let problem = match lookup(name) {
                Some(text) => match text.trim().parse() {
                    Ok(number) => return Ok(number),
                    Err(_) => format!("is `{text}`, not a whole number"),
                },
                None => match default {
                    Some(number) => return Ok(number),
                    None => "is not set, though the task's index is; give the shard as i/n".into(),
                },
            };
            Err(BakeError::Shard { place: name.into(), problem })
        };
        let fitting = |name: &str, index: u64, count: u64| {
            let place = format!("{name}, as task {index} of {count}");
            Self::checked(index, count).map_err(|problem| BakeError::Shard { place, problem })
        };
        const SLURM: &str = "SLURM_ARRAY_TASK_ID";
        const AWS: &str = "AWS_BATCH_JOB_ARRAY_INDEX";
        const KUBERNETES: &str = "JOB_COMPLETION_INDEX";
        let is_set = |name: &str| lookup(name).is_some();
        if is_set(SLURM) {
            let (id, count) = (number(SLURM, None)?, number("SLURM_ARRAY_TASK_COUNT", None)?);
            let (first, step) = (number("SLURM_ARRAY_TASK_MIN", None)?, number("SLURM_ARRAY_TASK_STEP", Some(1))?);
            return match id.checked_sub(first) {
                Some(behind) if step > 0 && behind % step == 0 && behind / step < count => {
                    fitting(SLURM, behind / step, count)
                }
                _ => Err(BakeError::Shard {
                    place: SLURM.into(),
                    problem: format!(
                        "is {id}, but the array has {count} tasks from {first} in steps of {step}; submit it without \
                         gaps, as --array=0-{}: what is finished counts whatever the shards were",
                        count.saturating_sub(1)
                    ),
                }),
            };
        }
        if is_set(AWS) {
            return fitting(AWS, number(AWS, None)?, number("AWS_BATCH_JOB_ARRAY_SIZE", None)?);
        }
        if is_set(KUBERNETES) {
            return fitting(KUBERNETES, number(KUBERNETES, None)?, number("CATOPTRIC_SHARDS", None)?);
        }
        let problem = format!(
            "no scheduler has given this task an index: {SLURM} (Slurm), {AWS} (AWS Batch) and {KUBERNETES} \
            (Kubernetes, \
             with CATOPTRIC_SHARDS) are not set; give the shard as i/n, such as 0/4"
        );
        Err(BakeError::Shard { place: "the environment".into(), problem })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = BakeError;

    /// Reads `i/n`, such as `0/4` to `3/4`.
    fn from_str(text: &str) -> Result<Self, BakeError> {
        let wrong = |problem: String| BakeError::Shard { place: format!("shard `{text}`"), problem };
        let form = || wrong("must be i/n with whole numbers, such as 0/4".into());
        let (index, count) = text.split_once('/').ok_or_else(form)?;
        let (index, count) = (index.parse().map_err(|_| form())?, count.parse().map_err(|_| form())?);
        Self::checked(index, count).map_err(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_batch_is_in_one_shard() {
        for total in 0..20 {
            let batches: Vec<u64> = (0..total).collect();
            for count in 1..25 {
                let mut seen = vec![0; total as usize];
                for index in 0..count {
                    for batch in Shard::new(index, count).unwrap().of(&batches) {
                        assert_eq!(batch % count, index);
                        seen[*batch as usize] += 1;
                    }
                }
                assert!(seen.iter().all(|&times| times == 1), "{total} batches, {count} shards: {seen:?}");
            }
        }
        let last = Shard::new(u64::MAX - 1, u64::MAX).unwrap();
        assert_eq!(last.of(&[1, 2, 3]).count(), 0);
    }

    #[test]
    fn is_read_as_it_is_written() {
        let shard: Shard = "3/7".parse().unwrap();
        assert_eq!((shard.index(), shard.count(), shard.to_string().as_str()), (3, 7, "3/7"));
        for wrong in ["", "3", "3/", "/7", "-1/7", "a/b", "1/2/3", "0/0", "7/7", "1 / 2", "99999999999999999999/7"] {
            let message = wrong.parse::<Shard>().unwrap_err().to_string();
            assert!(message.contains(&format!("`{wrong}`")), "{message}");
        }
        assert!("7/7".parse::<Shard>().unwrap_err().to_string().contains("0/7 to 6/7"));
        assert!(Shard::new(1, 0).is_err());
    }

    fn environment(variables: &[(&str, &str)]) -> Result<Shard, BakeError> {
        let find = |name: &str| variables.iter().find(|entry| entry.0 == name).map(|entry| entry.1.to_string());
        Shard::from_environment(find)
    }

    fn slurm(id: &str, count: &str, first: &str, step: &str) -> Result<Shard, BakeError> {
        environment(&[
            ("SLURM_ARRAY_TASK_ID", id),
            ("SLURM_ARRAY_TASK_COUNT", count),
            ("SLURM_ARRAY_TASK_MIN", first),
            ("SLURM_ARRAY_TASK_STEP", step),
        ])
    }

    #[test]
    fn schedulers_give_shards() {
        assert_eq!(slurm("5", "4", "3", "1").unwrap(), Shard::new(2, 4).unwrap());
        assert_eq!(slurm("7", "4", "1", "2").unwrap(), Shard::new(3, 4).unwrap());
        let aws = environment(&[("AWS_BATCH_JOB_ARRAY_INDEX", "1"), ("AWS_BATCH_JOB_ARRAY_SIZE", "2")]);
        assert_eq!(aws.unwrap(), Shard::new(1, 2).unwrap());
        let kubernetes = environment(&[("JOB_COMPLETION_INDEX", "0"), ("CATOPTRIC_SHARDS", "8")]);
        assert_eq!(kubernetes.unwrap(), Shard::new(0, 8).unwrap());
    }

    #[test]
    fn what_schedulers_do_not_say_is_named() {
        let message = |found: Result<Shard, BakeError>| found.unwrap_err().to_string();
        let nothing = message(environment(&[]));
        for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "AWS_BATCH_JOB_ARRAY_INDEX", "i/n"] {
            assert!(nothing.contains(name), "{nothing}");
        }
        assert!(message(environment(&[("JOB_COMPLETION_INDEX", "1")])).contains("CATOPTRIC_SHARDS: is not set"));
        assert!(message(environment(&[("SLURM_ARRAY_TASK_ID", "x")])).contains("SLURM_ARRAY_TASK_ID: is `x`"));
        // An array with gaps: 3 and 7.
        assert!(message(slurm("7", "2", "3", "1")).contains("--array=0-1"));
        for (id, count, first, step) in
            [("1", "4", "3", "1"), ("4", "4", "1", "2"), ("1", "4", "0", "0"), ("0", "0", "0", "1")]
        {
            assert!(slurm(id, count, first, step).is_err());
        }
        let beyond = environment(&[("JOB_COMPLETION_INDEX", "8"), ("CATOPTRIC_SHARDS", "8")]);
        assert!(message(beyond).contains("0/8 to 7/8"));
    }
}
