//! Cameras as words of 32 bits, the lowest byte first, for baked files.

use bytemuck::Pod;

/// Writes words.
#[derive(Debug, Default)]
pub struct WordWriter(Vec<u32>);

impl WordWriter {
    /// Writes one number.
    pub fn number(&mut self, number: u32) {
        self.0.push(number);
    }

    /// Numbers in single precision, without their count.
    pub fn floats(&mut self, numbers: &[f32]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    /// A list with its length.
    pub fn numbers(&mut self, numbers: &[u32]) {
        self.number(numbers.len() as u32);
        self.0.extend_from_slice(numbers);
    }

    /// A list of records, all of whose fields are numbers of 32 bits, with its length.
    pub fn records<T: Pod>(&mut self, records: &[T]) {
        self.number(records.len() as u32);
        self.0.extend_from_slice(bytemuck::cast_slice(records));
    }

    /// Numbers of 64 bits.
    pub(in super::super) fn counts(&mut self, counts: [u64; 3]) {
        self.records(&counts.map(|count| [count as u32, (count >> 32) as u32]));
    }

    /// A list in which neighbours are mostly equal: values with how often they follow one another.
    pub fn runs(&mut self, values: impl Iterator<Item = u32>) {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for value in values {
            match runs.last_mut().filter(|run| run[0] == value && run[1] < u32::MAX) {
                Some(run) => run[1] += 1,
                None => runs.push([value, 1]),
            }
        }
        self.records(&runs);
    }

    /// The bytes of all words.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}

/// Reads words; everything is `None` beyond their end, and nothing in them is believed.
#[derive(Clone, Copy, Debug)]
pub struct WordReader<'a>(&'a [u32]);

impl<'a> WordReader<'a> {
    /// A reader at the first of some words.
    pub fn new(words: &'a [u32]) -> Self {
        Self(words)
    }

    /// The number of words that are not read yet.
    pub fn left(&self) -> usize {
        self.0.len()
    }

    fn take(&mut self, count: usize) -> Option<&'a [u32]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// Reads one number.
    pub fn number(&mut self) -> Option<u32> {
        self.take(1).map(|taken| taken[0])
    }

    /// The numbers of [`WordWriter::floats`].
    pub fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        self.take(N)?.first_chunk().map(|taken: &[u32; N]| taken.map(f32::from_bits))
    }

    /// The numbers of [`WordWriter::numbers`].
    pub fn numbers(&mut self) -> Option<&'a [u32]> {
        let count = self.number()?;
        self.take(count as usize)
    }

    /// The records of [`WordWriter::records`].
    pub fn records<T: Pod>(&mut self) -> Option<Vec<T>> {
        let count = self.number()? as usize;
        let taken = self.take(count.checked_mul(size_of::<T>() / size_of::<u32>())?)?;
        Some(bytemuck::pod_collect_to_vec(taken))
    }

    pub(in super::super) fn counts(&mut self) -> Option<[u64; 3]> {
        let counts: [[u32; 2]; 3] = self.records()?.try_into().ok()?;
        Some(counts.map(|[low, high]| u64::from(high) << 32 | u64::from(low)))
    }

    /// The values of [`WordWriter::runs`], which are that many.
    pub fn runs(&mut self, count: usize) -> Option<Vec<u32>> {
        let mut values = Vec::new();
        for [value, times] in self.records::<[u32; 2]>()? {
            let end = values.len().checked_add(times as usize).filter(|end| *end <= count)?;
            values.resize(end, value);
        }
        (values.len() == count).then_some(values)
    }
}
