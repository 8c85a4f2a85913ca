mod beams;
mod candidate_filter;
mod candidates;
mod samples;
