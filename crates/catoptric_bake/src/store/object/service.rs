//! Whose object store it is: clients, and the variables that they are set up by.

use super::{crypto, describe, options, retries};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use std::sync::Arc;
use std::time::Duration;

/// A kind of object stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Service {
    /// S3, and servers with the same interface.
    Amazon,
    Google,
    Azure,
}

/// The names that Azure's own programs have for variables of the client's.
const AZURE_NAMES: [(&str, &str); 3] = [
    ("AZURE_STORAGE_ACCOUNT", "azure_storage_account_name"),
    ("AZURE_STORAGE_KEY", "azure_storage_account_key"),
    ("AZURE_STORAGE_SAS_TOKEN", "azure_storage_sas_token"),
];

impl Service {
    /// The service of an address, and what follows its scheme.
    pub(super) fn of_address(address: &str) -> Option<(Self, &str)> {
        let (scheme, rest) = address.split_once("://")?;
        let service = match scheme {
            "s3" => Self::Amazon,
            "gs" => Self::Google,
            "az" => Self::Azure,
            _ => return None,
        };
        Some((service, rest))
    }

    /// The variables that tell who asks, for messages.
    pub(super) fn credentials(self) -> &'static str {
        match self {
            Self::Amazon => "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY",
            Self::Google => "GOOGLE_APPLICATION_CREDENTIALS",
            Self::Azure => "AZURE_STORAGE_ACCOUNT, AZURE_STORAGE_KEY",
        }
    }

    /// The variables that tell where the server is, for messages.
    pub(super) fn places(self) -> &'static str {
        match self {
            Self::Amazon => "AWS_REGION, AWS_ENDPOINT_URL",
            Self::Google => "GOOGLE_BASE_URL",
            Self::Azure => "AZURE_STORAGE_ENDPOINT",
        }
    }

    /// The client for a bucket (Azure: a container), set up by variables of the environment. Others are ignored.
    ///
    /// # Errors
    /// What does not fit.
    pub(super) fn client(
        self,
        bucket: &str,
        patience: Duration,
        variables: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Arc<dyn object_store::ObjectStore>, String> {
        let crypto = Arc::new(crypto::Crypto);
        let wrong = |error: object_store::Error| describe(&error);
        let named = |start: &'static str| move |(name, _): &(String, String)| name.starts_with(start);
        match self {
            Self::Amazon => {
                let mut builder = AmazonS3Builder::new().with_client_options(options());
                for (name, value) in variables.into_iter().filter(named("AWS_")) {
                    if let Ok(key) = name.to_ascii_lowercase().parse::<AmazonS3ConfigKey>() {
                        builder = builder.with_config(key, value);
                    }
                }
                let builder = builder.with_bucket_name(bucket).with_crypto_provider(crypto);
                Ok(Arc::new(builder.with_retry(retries(patience)).build().map_err(wrong)?))
            }
            Self::Google => {
                let mut builder = GoogleCloudStorageBuilder::new().with_client_options(options());
                for (name, value) in variables.into_iter().filter(named("GOOGLE_")) {
                    if let Ok(key) = name.to_ascii_lowercase().parse::<GoogleConfigKey>() {
                        builder = builder.with_config(key, value);
                    }
                }
                let builder = builder.with_bucket_name(bucket).with_crypto_provider(crypto);
                Ok(Arc::new(builder.with_retry(retries(patience)).build().map_err(wrong)?))
            }
            Self::Azure => {
                let mut builder = MicrosoftAzureBuilder::new().with_client_options(options());
                for (name, value) in variables.into_iter().filter(named("AZURE_")) {
                    let own = AZURE_NAMES.iter().find(|(theirs, _)| *theirs == name).map(|(_, own)| (*own).to_owned());
                    if let Ok(key) = own.unwrap_or_else(|| name.to_ascii_lowercase()).parse::<AzureConfigKey>() {
                        builder = builder.with_config(key, value);
                    }
                }
                let builder = builder.with_container_name(bucket).with_crypto_provider(crypto);
                Ok(Arc::new(builder.with_retry(retries(patience)).build().map_err(wrong)?))
            }
        }
    }
}
