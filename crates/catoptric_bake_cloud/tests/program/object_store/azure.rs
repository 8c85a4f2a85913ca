//! The part of Azure Blob Storage that bakes need, by its documentation: blobs of one container, over a folder.

use hyper::body::Bytes;
use hyper::header::{AUTHORIZATION, CONTENT_LENGTH, CONTENT_TYPE, ETAG, HeaderValue, IF_NONE_MATCH, LAST_MODIFIED};
use hyper::http::request::Parts;
use hyper::{Method, Response, StatusCode};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

pub(crate) const ACCOUNT: &str = "account";
/// In base64.
pub(crate) const KEY: &str = "dGVzdC1rZXk=";

const MODIFIED: &str = "Sat, 28 Nov 2026 00:00:00 GMT";

/// Names of a page of a listing.
const PAGE: usize = 400;

/// A container.
#[derive(Clone)]
pub(crate) struct Container {
    folder: PathBuf,
    name: String,
}

impl Container {
    /// The container of this name, whose blobs are files below a folder.
    pub(crate) fn new(folder: &Path, name: &str) -> Self {
        Self { folder: folder.to_owned(), name: name.to_owned() }
    }

    /// Answers a request.
    pub(crate) fn answer(&self, request: &Parts, body: &Bytes) -> Response<Bytes> {
        let signed = request.headers.get(AUTHORIZATION).and_then(|said| said.to_str().ok()).unwrap_or_default();
        if !signed.starts_with(&format!("SharedKey {ACCOUNT}:")) {
            return said(StatusCode::FORBIDDEN, Bytes::new());
        }
        let (container, blob) = request.uri.path()[1..].split_once('/').unwrap_or((&request.uri.path()[1..], ""));
        if container != self.name {
            return said(StatusCode::NOT_FOUND, Bytes::new());
        }
        let path = self.folder.join(container).join(blob);
        match request.method {
            Method::GET if blob.is_empty() => self.listing(request.uri.query().unwrap_or_default()),
            Method::GET => fs::read(path).map_or_else(|_| said(StatusCode::NOT_FOUND, Bytes::new()), found),
            Method::POST if request.uri.query().is_some_and(|query| query.contains("comp=batch")) => self.batch(body),
            Method::PUT => {
                let is_block = request.headers.get("x-ms-blob-type").is_some_and(|kind| kind == "BlockBlob");
                let is_new = request.headers.get(IF_NONE_MATCH).is_some_and(|none| none == "*");
                assert!(is_block && is_new, "{request:?}");
                match create(&path, body) {
                    Ok(()) => said(StatusCode::CREATED, Bytes::new()),
                    Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                        said(StatusCode::CONFLICT, Bytes::from_static(b"<Error><Code>BlobAlreadyExists</Code></Error>"))
                    }
                    Err(error) => panic!("{error}"),
                }
            }
            _ => said(StatusCode::METHOD_NOT_ALLOWED, Bytes::new()),
        }
    }

    /// Removes the blobs that a batch of requests names.
    fn batch(&self, body: &Bytes) -> Response<Bytes> {
        let text = std::str::from_utf8(body).unwrap();
        let mut answers = String::new();
        for (number, line) in text.lines().filter(|line| line.starts_with("DELETE /")).enumerate() {
            let path = line.split([' ', '?']).nth(1).unwrap();
            let removed = fs::remove_file(self.folder.join(&path[1..]));
            let status = if removed.is_ok() { "202 Accepted" } else { "404 The specified blob does not exist." };
            write!(
                answers,
                "--batch\r\nContent-Type: application/http\r\nContent-ID: {number}\r\n\r\n\
                 HTTP/1.1 {status}\r\nx-ms-version: 2018-11-09\r\n\r\n"
            )
            .unwrap();
        }
        let mut response = said(StatusCode::ACCEPTED, Bytes::from(answers + "--batch--\r\n"));
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("multipart/mixed; boundary=batch"));
        response
    }

    /// The blobs and folders below a prefix, a page of them.
    fn listing(&self, query: &str) -> Response<Bytes> {
        let query: BTreeMap<&str, String> =
            query.split('&').filter_map(|pair| pair.split_once('=')).map(unescaped).collect();
        let of = |name: &str| query.get(name).cloned().unwrap_or_default();
        assert!(of("restype") == "container" && of("comp") == "list" && of("delimiter") == "/", "{query:?}");
        let (prefix, from) = (of("prefix"), of("marker"));
        let folder = self.folder.join(&self.name).join(&prefix);
        let names: BTreeSet<String> = fs::read_dir(folder).into_iter().flatten().map(name).collect();
        let mut rest = names.into_iter().filter(|name| *name >= from);
        let mut blobs = String::new();
        for name in rest.by_ref().take(PAGE) {
            let bytes = fs::metadata(self.folder.join(&self.name).join(&prefix).join(&name)).unwrap().len();
            let properties = format!(
                "<Last-Modified>{MODIFIED}</Last-Modified><Content-Length>{bytes}</Content-Length>\
                 <Content-Type>application/octet-stream</Content-Type><Etag>\"1\"</Etag>"
            );
            write!(blobs, "<Blob><Name>{prefix}{name}</Name><Properties>{properties}</Properties></Blob>").unwrap();
        }
        let next = rest.next().unwrap_or_default();
        let text = format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?><EnumerationResults><Prefix>{prefix}</Prefix>\
             <Blobs>{blobs}</Blobs><NextMarker>{next}</NextMarker></EnumerationResults>"
        );
        said(StatusCode::OK, Bytes::from(text))
    }
}

/// A pair of a query. No name of these tests has other letters that are escaped.
fn unescaped<'a>((name, value): (&'a str, &str)) -> (&'a str, String) {
    (name, value.replace("%2F", "/"))
}

fn name(entry: io::Result<fs::DirEntry>) -> String {
    entry.unwrap().file_name().into_string().unwrap()
}

/// Writes a file that must not be there yet.
fn create(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap();
    fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder.parent().unwrap())?;
    io::Write::write_all(&mut file, bytes)?;
    file.persist_noclobber(path).map(drop).map_err(|error| error.error)
}

fn found(bytes: Vec<u8>) -> Response<Bytes> {
    said(StatusCode::OK, Bytes::from(bytes))
}

fn said(status: StatusCode, body: Bytes) -> Response<Bytes> {
    let length = body.len().to_string();
    let headers = [(ETAG, "\"1\""), (LAST_MODIFIED, MODIFIED), (CONTENT_LENGTH, &length)];
    let headers = headers.into_iter().map(|(name, value)| (name, value.parse().unwrap()));
    let mut response = Response::new(body);
    *response.status_mut() = status;
    response.headers_mut().extend(headers);
    response
}
