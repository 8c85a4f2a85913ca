//! Words that are written and read.

use catoptric_projection::parts::{WordReader, WordWriter};

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
