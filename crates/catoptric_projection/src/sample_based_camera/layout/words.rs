//! Cameras as words of 32 bits, the lowest byte first: what a baked file holds.

use bytemuck::Pod;

/// Writes words.
#[derive(Debug, Default)]
pub(in super::super) struct WordWriter(Vec<u32>);

impl WordWriter {
    pub(in super::super) fn number(&mut self, number: u32) {
        self.0.push(number);
    }

    pub(in super::super) fn floats(&mut self, numbers: &[f32]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    /// A list with its length.
    pub(in super::super) fn numbers(&mut self, numbers: &[u32]) {
        self.number(numbers.len() as u32);
        self.0.extend_from_slice(numbers);
    }

    /// A list of records, all of whose fields are numbers of 32 bits, with its length.
    pub(in super::super) fn records<T: Pod>(&mut self, records: &[T]) {
        self.number(records.len() as u32);
        self.0.extend_from_slice(bytemuck::cast_slice(records));
    }

    /// Numbers of 64 bits.
    pub(in super::super) fn counts(&mut self, counts: [u64; 3]) {
        self.records(&counts.map(|count| [count as u32, (count >> 32) as u32]));
    }

    /// A list in which neighbours are mostly equal: values with how often they follow one another.
    pub(in super::super) fn runs(&mut self, values: impl Iterator<Item = u32>) {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for value in values {
            match runs.last_mut().filter(|run| run[0] == value && run[1] < u32::MAX) {
                Some(run) => run[1] += 1,
                None => runs.push([value, 1]),
            }
        }
        self.records(&runs);
    }

    pub(in super::super) fn into_bytes(self) -> Vec<u8> {
        self.0.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}

/// Reads words; everything is `None` beyond their end, and nothing in them is believed.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct WordReader<'a>(&'a [u32]);

impl<'a> WordReader<'a> {
    pub(in super::super) fn new(words: &'a [u32]) -> Self {
        Self(words)
    }

    /// The number of words that are not read yet.
    pub(in super::super) fn left(&self) -> usize {
        self.0.len()
    }

    fn take(&mut self, count: usize) -> Option<&'a [u32]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    pub(in super::super) fn number(&mut self) -> Option<u32> {
        self.take(1).map(|taken| taken[0])
    }

    pub(in super::super) fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        self.take(N)?.first_chunk().map(|taken: &[u32; N]| taken.map(f32::from_bits))
    }

    pub(in super::super) fn numbers(&mut self) -> Option<&'a [u32]> {
        let count = self.number()?;
        self.take(count as usize)
    }

    pub(in super::super) fn records<T: Pod>(&mut self) -> Option<Vec<T>> {
        let count = self.number()? as usize;
        let taken = self.take(count.checked_mul(size_of::<T>() / size_of::<u32>())?)?;
        Some(bytemuck::pod_collect_to_vec(taken))
    }

    pub(in super::super) fn counts(&mut self) -> Option<[u64; 3]> {
        let counts: [[u32; 2]; 3] = self.records()?.try_into().ok()?;
        Some(counts.map(|[low, high]| u64::from(high) << 32 | u64::from(low)))
    }

    /// The values of [`WordWriter::runs`], which are that many.
    pub(in super::super) fn runs(&mut self, count: usize) -> Option<Vec<u32>> {
        let mut values = Vec::new();
        for [value, times] in self.records::<[u32; 2]>()? {
            let end = values.len().checked_add(times as usize).filter(|end| *end <= count)?;
            values.resize(end, value);
        }
        (values.len() == count).then_some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut written = WordWriter::default();
        written.number(7);
        written.floats(&[0.5, -1.0]);
        written.numbers(&[1, 2, 3]);
        written.records(&[[1.5f32, 2.5]]);
        written.runs([4, 4, 4, 9, 4].into_iter());
        let bytes = written.into_bytes();
        assert_eq!(bytes.len(), (1 + 2 + 4 + 3 + 7) * 4);
        let words: Vec<u32> = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let read = |words: &[u32], values: usize| {
            let mut reader = WordReader::new(words);
            let number = reader.number()?;
            let floats: [f32; 2] = reader.floats()?;
            let (numbers, records) = (reader.numbers()?.to_vec(), reader.records::<[f32; 2]>()?);
            let runs = reader.runs(values)?;
            (reader.left() == 0).then_some((number, floats, numbers, records, runs))
        };
        let expected = (7, [0.5, -1.0], vec![1, 2, 3], vec![[1.5, 2.5]], vec![4, 4, 4, 9, 4]);
        assert_eq!(read(&words, 5), Some(expected));
        assert_eq!((read(&words, 4), read(&words, 6)), (None, None));
        for end in 0..words.len() {
            assert_eq!(read(&words[..end], 5), None);
        }
        // Lengths that lie.
        for at in 0..words.len() {
            let mut words = words.clone();
            words[at] = u32::MAX;
            read(&words, 5);
        }
    }
}
