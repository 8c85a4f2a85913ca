//! Where a picked point appears, as text.

use super::error::WireError;
use super::wish::WireWish;
use crate::studio::places::{Place, Places};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[derive(Serialize, Deserialize)]
pub(super) struct WirePlaces {
    number: u64,
    wish: WireWish,
    truth_px: [f32; 2],
    is_solved: bool,
    list: Vec<(String, [f32; 2], f32, String)>,
    silent: Vec<(String, String)>,
    is_done: bool,
}

impl From<Places> for WirePlaces {
    fn from(Places { number, wish, truth_px, is_solved, list, silent, is_done }: Places) -> Self {
        let place = |place: Place| (place.method, place.position_px, place.offset_px, place.remark);
        let (wish, list) = (WireWish::from(&*wish), list.into_iter().map(place).collect());
        Self { number, wish, truth_px, is_solved, list, silent, is_done }
    }
}

impl WirePlaces {
    pub(super) fn read(self) -> Result<Places, WireError> {
        let Self { number, wish, truth_px, is_solved, list, silent, is_done } = self;
        let place = |(method, position_px, offset_px, remark)| Place { method, position_px, offset_px, remark };
        let (wish, list) = (Arc::new(wish.read()?), list.into_iter().map(place).collect());
        Ok(Places { number, wish, truth_px, is_solved, list, silent, is_done })
    }
}
