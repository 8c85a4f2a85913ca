//! Bakes of [`catoptric_bake`] where there is no shared folder or no patience: an [`ObjectStore`] is a
//! [`Store`](catoptric_bake::Store) in S3, Google Cloud Storage or Azure Blob Storage, [`SlurmScripts`] have a cluster
//! make the units and merge them.

mod object;
mod slurm;

pub use object::ObjectStore;
pub use slurm::{SlurmError, SlurmJobs, SlurmScripts};
