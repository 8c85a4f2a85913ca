mod candidates;
mod samples;
mod tubes;
