//! Requests to servers: how long they may take, how often they are tried again, and the texts of their errors.

use object_store::client::{HttpError, HttpErrorKind};
use object_store::{BackoffConfig, ClientOptions, RetryConfig};
use std::error::Error;
use std::time::Duration;

/// The longest pause between two attempts.
pub(super) const LONGEST_PAUSE: Duration = Duration::from_secs(10);

/// The time for one request: enough for the largest unit at a megabyte a second.
const REQUEST_TIME: Duration = Duration::from_secs(120);

/// The time for a connection.
const CONNECT_TIME: Duration = Duration::from_secs(10);

pub(super) fn options() -> ClientOptions {
    ClientOptions::new().with_timeout(REQUEST_TIME).with_connect_timeout(CONNECT_TIME)
}

pub(super) fn retries(patience: Duration) -> RetryConfig {
    let init_backoff = Duration::from_millis(100);
    let backoff = BackoffConfig { init_backoff, max_backoff: LONGEST_PAUSE, base: 2.0 };
    // The time ends the attempts.
    RetryConfig { backoff, max_retries: 1000, retry_timeout: patience }
}

/// True if an error is one of the connection, not an answer of the server.
pub(super) fn is_cut(error: &object_store::Error) -> bool {
    let mut cause: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(error) = cause {
        if let Some(error) = error.downcast_ref::<HttpError>() {
            // The rest are requests that could not even be made.
            return !matches!(error.kind(), HttpErrorKind::Unknown);
        }
        cause = error.source();
    }
    false
}

/// An error with its causes, as far as they are not in its message already, on one line.
pub(super) fn describe(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let more = error.to_string();
        if !text.contains(&more) {
            text += &format!(": {more}");
        }
        cause = error.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
