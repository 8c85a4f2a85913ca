//! Work on all cores.

use catoptric_core::parallel::{for_each_chunk_mut, for_each_mut, map_collect, map_init_collect};

#[test]
fn results_are_in_order_and_complete() {
    for count in [0, 1, 2, 3, 7, 1000, 12_345] {
        let expected: Vec<String> = (0..count).map(|index| index.to_string()).collect();
        assert_eq!(map_collect(count, |index| index.to_string()), expected);
        let with_scratch = map_init_collect(count, Vec::new, |scratch, index| {
            scratch.push(index);
            scratch.last().map(usize::to_string).unwrap_or_default()
        });
        assert_eq!(with_scratch, expected);
    }
}

#[test]
fn every_chunk_is_met_once_with_its_number() {
    for (length, size) in [(0, 3), (1, 3), (3, 3), (10, 3), (1000, 1), (1001, 7), (5, 100)] {
        let mut data = vec![(usize::MAX, 0); length];
        for_each_chunk_mut(&mut data, size, |number, chunk| {
            assert!(chunk.len() == size || number == length / size);
            chunk.iter_mut().for_each(|(owner, times)| (*owner, *times) = (number, *times + 1));
        });
        let expected: Vec<_> = (0..length).map(|index| (index / size, 1)).collect();
        assert_eq!(data, expected);
    }
    let mut squares = vec![0; 777];
    for_each_mut(&mut squares, |index, square| *square = index * index);
    assert!(squares.iter().enumerate().all(|(index, square)| *square == index * index));
}
