//! Whose object store it is: clients, and the variables that they are set up by.

use super::crypto;
use super::requests::{describe, options, retries};
use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use std::str::FromStr;
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
    ("AZURE_STORAGE_ACCOUNT", "AZURE_STORAGE_ACCOUNT_NAME"),
    ("AZURE_STORAGE_KEY", "AZURE_STORAGE_ACCOUNT_KEY"),
    ("AZURE_STORAGE_SAS_TOKEN", "AZURE_STORAGE_SAS_KEY"),
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
    /// The text about variables that do not fit.
    pub(super) fn client(
        self,
        bucket: &str,
        patience: Duration,
        variables: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Arc<dyn object_store::ObjectStore>, String> {
        let (crypto, retries) = (Arc::new(crypto::Crypto), retries(patience));
        let wrong = |error: object_store::Error| describe(&error);
        match self {
            Self::Amazon => {
                let plain = AmazonS3Builder::new().with_client_options(options());
                let builder = configured(plain, "AWS_", variables, AmazonS3Builder::with_config);
                let builder = builder.with_bucket_name(bucket).with_crypto_provider(crypto).with_retry(retries);
                Ok(Arc::new(builder.build().map_err(wrong)?))
            }
            Self::Google => {
                let plain = GoogleCloudStorageBuilder::new().with_client_options(options());
                let builder = configured(plain, "GOOGLE_", variables, GoogleCloudStorageBuilder::with_config);
                let builder = builder.with_bucket_name(bucket).with_crypto_provider(crypto).with_retry(retries);
                Ok(Arc::new(builder.build().map_err(wrong)?))
            }
            Self::Azure => {
                let variables = variables.into_iter().map(|(name, value)| {
                    let own = AZURE_NAMES.iter().find(|(theirs, _)| *theirs == name);
                    (own.map_or(name, |(_, own)| (*own).to_owned()), value)
                });
                let plain = MicrosoftAzureBuilder::new().with_client_options(options());
                let builder = configured(plain, "AZURE_", variables, MicrosoftAzureBuilder::with_config);
                let builder = builder.with_container_name(bucket).with_crypto_provider(crypto).with_retry(retries);
                Ok(Arc::new(builder.build().map_err(wrong)?))
            }
        }
    }
}

/// A client's builder with the variables that begin so and that it knows.
fn configured<B, K: FromStr>(
    builder: B,
    start: &str,
    variables: impl IntoIterator<Item = (String, String)>,
    with: impl Fn(B, K, String) -> B,
) -> B {
    let known = |(name, value): (String, String)| {
        let key = name.starts_with(start).then(|| name.to_ascii_lowercase().parse().ok())??;
        Some((key, value))
    };
    variables.into_iter().filter_map(known).fold(builder, |builder, (key, value)| with(builder, key, value))
}
