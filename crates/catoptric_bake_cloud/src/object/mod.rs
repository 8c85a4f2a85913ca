//! An object store, such as S3, as a store.

mod crypto;
mod requests;
mod service;

use catoptric_bake::{BakeError, Created, Entry, Store, check_name};
use object_store::path::Path;
use object_store::{ObjectStore as _, ObjectStoreExt, PutMode};
use requests::{LONGEST_PAUSE, describe, is_cut};
use service::Service;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::runtime::Runtime;

/// A prefix in a bucket of S3, of a server with the same interface, of Google Cloud Storage, or in a container of Azure
/// Blob Storage.
///
/// An object appears whole or not at all, and the server refuses to create what is there already (`If-None-Match: *`,
/// at Google's `x-goog-if-generation-match: 0`).
/// Busy servers (status 503 and the like) and connections that are cut are tried again, for a while.
pub struct ObjectStore {
    /// Such as `s3://bucket/prefix`.
    address: String,
    service: Service,
    prefix: Path,
    client: Arc<dyn object_store::ObjectStore>,
    runtime: Runtime,
    patience: Duration,
}

impl ObjectStore {
    /// The time for which a busy or broken server is tried again.
    pub const PATIENCE: Duration = Duration::from_secs(120);

    /// The store of an address: `s3://bucket/prefix`, `gs://bucket/prefix` at Google's, `az://container/prefix` at
    /// Azure's. Nothing is sent yet.
    ///
    /// `variables` are those of the environment:
    /// * `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_SESSION_TOKEN`, `AWS_REGION`; for other servers
    ///   `AWS_ENDPOINT_URL`, and `AWS_ALLOW_HTTP=true` if that is plain HTTP;
    /// * `GOOGLE_APPLICATION_CREDENTIALS`, the file of an account's key;
    /// * `AZURE_STORAGE_ACCOUNT`, and `AZURE_STORAGE_KEY` or `AZURE_STORAGE_SAS_TOKEN`.
    ///
    /// On the providers' own machines those of their role are found without.
    ///
    /// # Errors
    /// [`BakeError::Invalid`] for what is no such address, and for variables that do not fit; [`BakeError::Read`] where
    /// this machine cannot encrypt or start a thread.
    pub fn open(
        address: &str,
        patience: Duration,
        variables: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self, BakeError> {
        let invalid = |problem: String| BakeError::invalid(address, "address", problem);
        let all = "s3://bucket/prefix, gs://bucket/prefix or az://container/prefix";
        let (service, rest) =
            Service::of_address(address).ok_or_else(|| invalid(format!("must be a folder, or {all}")))?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        let prefix = prefix.trim_end_matches('/');
        if bucket.is_empty() || prefix.is_empty() {
            return Err(invalid(format!("must be {all}, each with a name")));
        }
        let prefix = Path::parse(prefix).map_err(|error| invalid(describe(&error)))?;
        crypto::prepare().map_err(|error| BakeError::read(address, error))?;
        let client = service.client(bucket, patience, variables).map_err(invalid)?;
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime = runtime.map_err(|error| BakeError::read(address, error))?;
        let address = address.trim_end_matches('/').to_owned();
        Ok(Self { address, service, prefix, client, runtime, patience })
    }

    fn path(&self, name: &str) -> Result<Path, BakeError> {
        check_name(name, &self.place(name))?;
        Ok(self.prefix.clone().join(name))
    }

    /// Tries again when a connection is cut. The client itself does so only for requests that may be sent twice without
    /// harm, to which creating does not belong: here it does, since whoever finds a file already there compares it.
    fn attempt<T>(&self, act: impl AsyncFn() -> object_store::Result<T>) -> object_store::Result<T> {
        let begun = Instant::now();
        let mut pause = Duration::from_millis(100);
        loop {
            match self.runtime.block_on(act()) {
                Err(error) if is_cut(&error) && begun.elapsed() + pause < self.patience => {
                    std::thread::sleep(pause);
                    pause = (pause * 2).min(LONGEST_PAUSE);
                }
                result => return result,
            }
        }
    }
}

/// True for the address of an object store; all else is a folder.
pub(crate) fn is_address(place: &str) -> bool {
    Service::of_address(place).is_some()
}

/// The error with what to do about it.
fn failed(error: &object_store::Error, service: Service) -> io::Error {
    use object_store::Error as Fault;
    let (credentials, places) = (service.credentials(), service.places());
    let (kind, remedy) = match error {
        Fault::NotFound { .. } => (io::ErrorKind::NotFound, "is the bucket's name right?".to_owned()),
        Fault::PermissionDenied { .. } | Fault::Unauthenticated { .. } => {
            (io::ErrorKind::PermissionDenied, format!("check {credentials} and who may use the bucket"))
        }
        _ => {
            let kept = "then run again: what is published already is kept";
            (io::ErrorKind::Other, format!("check {places} and the credentials in {credentials}, {kept}"))
        }
    };
    io::Error::new(kind, format!("{}; {remedy}", describe(error)))
}

impl Store for ObjectStore {
    fn create(&self, name: &str, bytes: &[u8]) -> Result<Created, BakeError> {
        let path = self.path(name)?;
        let bytes = bytes::Bytes::copy_from_slice(bytes);
        let put = async || self.client.put_opts(&path, bytes.clone().into(), PutMode::Create.into()).await;
        match self.attempt(put) {
            Ok(_) => Ok(Created::New),
            Err(object_store::Error::AlreadyExists { .. } | object_store::Error::Precondition { .. }) => {
                Ok(Created::Existed)
            }
            Err(error) => Err(BakeError::write(self.place(name), failed(&error, self.service))),
        }
    }

    fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BakeError> {
        let path = self.path(name)?;
        match self.attempt(async || self.client.get(&path).await?.bytes().await) {
            Ok(bytes) => Ok(Some(bytes.into())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(BakeError::read(self.place(name), failed(&error, self.service))),
        }
    }

    fn list(&self) -> Result<Vec<Entry>, BakeError> {
        let listed = self.attempt(async || self.client.list_with_delimiter(Some(&self.prefix)).await);
        let listed = listed.map_err(|error| BakeError::read(self.place(""), failed(&error, self.service)))?;
        let entry = |object: object_store::ObjectMeta| {
            Some(Entry { name: object.location.filename()?.to_owned(), bytes: object.size })
        };
        Ok(listed.objects.into_iter().filter_map(entry).collect())
    }

    fn remove(&self, name: &str) -> Result<(), BakeError> {
        let path = self.path(name)?;
        match self.attempt(async || self.client.delete(&path).await) {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(BakeError::write(self.place(name), failed(&error, self.service))),
        }
    }

    fn place(&self, name: &str) -> String {
        if name.is_empty() { self.address.clone() } else { format!("{}/{name}", self.address) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read() {
        let open = |address: &str| ObjectStore::open(address, Duration::ZERO, []);
        let store = open("s3://bucket/rooms/room/").unwrap();
        assert_eq!(
            (store.place(""), store.place("x")),
            ("s3://bucket/rooms/room".into(), "s3://bucket/rooms/room/x".into())
        );
        let account = [("AZURE_STORAGE_ACCOUNT", "account"), ("AZURE_STORAGE_KEY", "a2V5"), ("AWS_X", "y")];
        let account = account.map(|(name, value)| (name.to_owned(), value.to_owned()));
        for (address, service) in [("gs://bucket/room", Service::Google), ("az://container/room", Service::Azure)] {
            let store = ObjectStore::open(address, Duration::ZERO, account.clone()).unwrap();
            assert_eq!((store.place("x"), store.service), (format!("{address}/x"), service));
        }
        let error = open("az://container/room").err().unwrap().to_string();
        assert!(error.to_lowercase().contains("account"), "{error}");
        for wrong in ["s3://", "s3://bucket", "gs://bucket/", "az:///prefix", "ftp://bucket/prefix", "s3://bucket/a//b"]
        {
            let error = open(wrong).err().unwrap().to_string();
            assert!(error.contains(wrong) && error.contains("address"), "{error}");
        }
        for name in ["", ".hidden", "../up", "a/b", "ö"] {
            assert!(matches!(store.create(name, b""), Err(BakeError::Invalid { .. })), "{name}");
        }
    }

    #[test]
    fn causes_are_told_once() {
        let inner = io::Error::other("inner\n  text");
        let error = object_store::Error::Generic { store: "S3", source: Box::new(inner) };
        assert_eq!(describe(&error), "Generic S3 error: inner text");
        assert!(!is_cut(&error));
    }
}
