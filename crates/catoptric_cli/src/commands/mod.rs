//! The commands; each returns the text that goes to standard output.

pub(crate) mod bake;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod diff;
mod display;
pub(crate) mod doctor;
pub(crate) mod info;
pub(crate) mod methods;
pub(crate) mod project;
pub(crate) mod render;
pub(crate) mod scenes;
pub(crate) mod view;

pub(crate) use crate::report::pretty;

use crate::failure::text::MOST_OF_NAME;

/// Columns of text, each as wide as its widest cell, as long as that is no wider than a name.
pub(crate) fn columns(rows: &[Vec<String>]) -> String {
    let mut widths: Vec<usize> = Vec::new();
    for row in rows {
        widths.resize(widths.len().max(row.len()), 0);
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count().min(MOST_OF_NAME));
        }
    }
    let line = |row: &Vec<String>| {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}")).collect();
        cells.join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}
