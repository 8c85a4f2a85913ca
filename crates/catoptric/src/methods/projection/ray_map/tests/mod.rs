mod attempts;
mod beams;
mod candidates;
mod samples;
