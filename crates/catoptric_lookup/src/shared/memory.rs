//! Check that tables fit into memory.

use catoptric_engine::error::RenderError;

/// Tables that are larger are refused: machines that have so much memory are rare, and all others would stand still.
const MAX_BYTES: u64 = 16 << 30;

/// # Errors
/// [`RenderError::Limit`] where a table is larger than most machines' memory; `remedy` says what the user can do beside
/// choosing smaller sizes.
pub(crate) fn fit_into_memory(method: &'static str, table: &str, bytes: u64, remedy: &str) -> Result<(), RenderError> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let [needed, most] = [bytes, MAX_BYTES].map(|bytes| bytes as f64 / f64::from(1 << 30));
    let problem =
        format!("{table} take {needed:.1} GiB of memory, and {most:.0} is the most; choose smaller ones, or {remedy}");
    Err(RenderError::Limit { method, problem })
}
