//! Samples, beams and candidates of ray maps.

mod beams;
mod candidate_filter;
mod candidates;
mod samples;
