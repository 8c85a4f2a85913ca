//! The command line of `catoptric bake submit`.

use crate::parse;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// A scheduler that divides a bake among machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// An array job, and a job after it that makes what is missing again and merges
    Slurm,
}

#[derive(Args)]
pub(crate) struct BakeSubmitArgs {
    /// The place of the plan: a folder that all machines see, or s3://bucket/prefix, gs://.. or az://..
    #[arg(value_name = "PLACE", value_parser = parse::place(), help_heading = "Scene")]
    pub(crate) place: String,
    /// The scheduler
    #[arg(long, value_enum, value_name = "NAME", help_heading = "General")]
    pub(crate) engine: Engine,
    /// Tasks among which the units are divided, at most one for each unit
    #[arg(long, value_name = "N", default_value = "100", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    #[arg(help_heading = "General")]
    pub(crate) tasks: u64,
    /// Print the scripts and commands, write and submit nothing
    #[arg(long, help_heading = "Output")]
    pub(crate) dry_run: bool,
    /// File that the bake is merged into [default: the place's name with `.bake` for `.parts`, beside it]
    #[arg(long, short, value_name = "FILE", value_parser = parse::file(), help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// Options for sbatch, behind `--`
    #[arg(last = true, value_name = "OPTION", help_heading = "General")]
    pub(crate) sbatch: Vec<String>,
}
