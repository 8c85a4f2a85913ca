//! Signatures of requests and encryption of connections, by graviola: it needs no C to build.

use graviola::hashing::hmac::Hmac;
use graviola::hashing::{Hash, HashContext, HashOutput, Sha256};
use graviola::signing::rsa::SigningKey;
use object_store::client::{CryptoProvider, DigestAlgorithm, DigestContext, HmacContext, Signer, SigningAlgorithm};
use object_store::{Error, Result};
use rustls_pki_types::PrivateKeyDer;
use rustls_pki_types::pem::PemObject;
use std::io;

/// Makes graviola the process's way to encrypt, unless there is one.
///
/// # Errors
/// On processors that it does not work on; it would panic.
pub(super) fn prepare() -> io::Result<()> {
    if !graviola::util::is_cpu_supported() {
        let problem = "object stores need a processor of 2014 or later (AVX2, AES, ADX); use a folder";
        return Err(io::Error::new(io::ErrorKind::Unsupported, problem));
    }
    // Another one is as good.
    let _ = rustls_graviola::default_provider().install_default();
    Ok(())
}

#[derive(Debug)]
pub(super) struct Crypto;

impl CryptoProvider for Crypto {
    fn digest(&self, algorithm: DigestAlgorithm) -> Result<Box<dyn DigestContext>> {
        match algorithm {
            DigestAlgorithm::Sha256 => Ok(Running::new(State::Plain(Sha256::new()))),
            other => Err(unknown(format!("{other:?}"))),
        }
    }

    fn hmac(&self, algorithm: DigestAlgorithm, secret: &[u8]) -> Result<Box<dyn HmacContext>> {
        match algorithm {
            DigestAlgorithm::Sha256 => Ok(Running::new(State::Keyed(Hmac::new(secret)))),
            other => Err(unknown(format!("{other:?}"))),
        }
    }

    /// Keys of Google's accounts alone are used so.
    fn sign(&self, algorithm: SigningAlgorithm, pem: &[u8]) -> Result<Box<dyn Signer>> {
        match algorithm {
            SigningAlgorithm::RS256 => Ok(Box::new(AccountKey::new(pem)?)),
            other => Err(unknown(format!("{other:?}"))),
        }
    }
}

/// The RSA key of an account.
struct AccountKey(SigningKey);

impl AccountKey {
    fn new(pem: &[u8]) -> Result<Self> {
        let wrong = |problem: String| Error::Generic { store: "key", source: problem.into() };
        let key = PrivateKeyDer::from_pem_slice(pem)
            .map_err(|error| wrong(format!("the account's private key is no PEM text: {error}")))?;
        let read = match &key {
            PrivateKeyDer::Pkcs8(der) => SigningKey::from_pkcs8_der(der.secret_pkcs8_der()),
            PrivateKeyDer::Pkcs1(der) => SigningKey::from_pkcs1_der(der.secret_pkcs1_der()),
            _ => return Err(wrong("the account's private key is not one of RSA".into())),
        };
        read.map(Self).map_err(|error| wrong(format!("the account's private key cannot be read: {error:?}")))
    }
}

impl Signer for AccountKey {
    fn sign(&self, string_to_sign: &[u8]) -> Result<Vec<u8>> {
        let mut signature = vec![0; self.0.modulus_len_bytes()];
        let signed = self.0.sign_pkcs1_sha256(&mut signature, string_to_sign).map(<[u8]>::len);
        match signed {
            Ok(length) => {
                signature.truncate(length);
                Ok(signature)
            }
            Err(error) => Err(Error::Generic { store: "key", source: format!("{error:?}").into() }),
        }
    }
}

fn unknown(algorithm: String) -> object_store::Error {
    object_store::Error::NotSupported { source: format!("{algorithm} is not used by these stores").into() }
}

/// A hash that is being computed, plain or with a key.
enum State {
    Plain(<Sha256 as Hash>::Context),
    Keyed(Hmac<Sha256>),
}

/// A hash before and after its end.
struct Running {
    /// `None` once it is finished.
    state: Option<State>,
    output: Option<HashOutput>,
}

impl Running {
    fn new(state: State) -> Box<Self> {
        Box::new(Self { state: Some(state), output: None })
    }

    fn add(&mut self, bytes: &[u8]) {
        match &mut self.state {
            Some(State::Plain(state)) => state.update(bytes),
            Some(State::Keyed(state)) => state.update(bytes),
            None => {}
        }
    }

    fn end(&mut self) -> Result<&[u8]> {
        match self.state.take() {
            Some(State::Plain(state)) => self.output = Some(state.finish()),
            Some(State::Keyed(state)) => self.output = Some(state.finish()),
            None => {}
        }
        self.output.as_ref().map(AsRef::as_ref).ok_or_else(|| unknown("an unfinished hash".into()))
    }
}

impl DigestContext for Running {
    fn update(&mut self, data: &[u8]) {
        self.add(data);
    }

    fn finish(&mut self) -> Result<&[u8]> {
        self.end()
    }
}

impl HmacContext for Running {
    fn update(&mut self, data: &[u8]) {
        self.add(data);
    }

    fn finish(&mut self) -> Result<&[u8]> {
        self.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hexadecimal(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// FIPS 180-4's example, and the second case of RFC 4231.
    #[test]
    fn hashes_are_those_of_the_standards() {
        prepare().unwrap();
        let mut digest = Crypto.digest(DigestAlgorithm::Sha256).unwrap();
        digest.update(b"a");
        digest.update(b"bc");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hexadecimal(digest.finish().unwrap()), expected);
        assert_eq!(hexadecimal(digest.finish().unwrap()), expected);
        let mut hmac = Crypto.hmac(DigestAlgorithm::Sha256, b"Jefe").unwrap();
        hmac.update(b"what do ya want for nothing?");
        let expected = "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843";
        assert_eq!(hexadecimal(hmac.finish().unwrap()), expected);
    }

    /// Against another project's: `printf abc | openssl dgst -sha256 -sign test-key.pem`.
    #[test]
    fn signatures_are_those_of_openssl() {
        prepare().unwrap();
        let signer = Crypto.sign(SigningAlgorithm::RS256, include_bytes!("test-key.pem")).unwrap();
        assert_eq!(signer.sign(b"abc").unwrap(), include_bytes!("test-signature.bin"));
        for wrong in [&b""[..], b"-----BEGIN PRIVATE KEY-----\nMAA=\n-----END PRIVATE KEY-----\n"] {
            let error = Crypto.sign(SigningAlgorithm::RS256, wrong).err().unwrap().to_string();
            assert!(error.contains("the account's private key"), "{error}");
        }
    }
}
