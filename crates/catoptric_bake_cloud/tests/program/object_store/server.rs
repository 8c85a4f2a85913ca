//! A server on loopback with the interface of a provider, over a folder, that fails as often as a test wants.

use super::azure;
use http_body_util::BodyExt;
use hyper::body::{Body, Bytes, Frame, Incoming};
use hyper::header::{AUTHORIZATION, HeaderValue, IF_NONE_MATCH};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::TokioIo;
use s3s::auth::SimpleAuth;
use s3s::service::{S3Service, S3ServiceBuilder};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use tokio::net::TcpListener;

pub(crate) const BUCKET: &str = "bucket";
const KEY: &str = "test-key";
const SECRET: &str = "test-secret";
const TOKEN: &str = "test-token";

/// Whose interface a server has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Provider {
    Amazon,
    /// Google's for XML, which is that of S3 but for who asks and how it is said that nothing is to be there yet.
    Google,
    Azure,
}

impl Provider {
    pub(crate) const ALL: [Self; 3] = [Self::Amazon, Self::Google, Self::Azure];

    /// The address of a prefix.
    pub(crate) fn address(self, prefix: &str) -> String {
        let scheme = match self {
            Self::Amazon => "s3",
            Self::Google => "gs",
            Self::Azure => "az",
        };
        format!("{scheme}://{BUCKET}/{prefix}")
    }
}

/// The imitated service that answers requests.
#[derive(Clone)]
enum Service {
    Amazon(S3Service),
    Google(S3Service),
    Azure(azure::Container),
}

/// The treatment of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fate {
    Answered,
    /// The server is busy: status 503.
    Refused,
    /// The connection is cut before anything is done.
    CutBefore,
    /// The request is done, and the connection is cut before the answer.
    CutAfter,
    /// The request is done, and the connection is cut in the middle of the answer.
    CutWithin,
}

/// Every second request or more fails, in turn in every way, and twice in a row.
const FAULTS: [Fate; 11] = [
    Fate::Answered,
    Fate::Refused,
    Fate::Answered,
    Fate::CutBefore,
    Fate::Answered,
    Fate::CutAfter,
    Fate::CutAfter,
    Fate::Answered,
    Fate::CutWithin,
    Fate::Answered,
    Fate::CutWithin,
];

/// The server's state, shared by all connections.
#[derive(Default)]
struct State {
    fails: AtomicBool,
    refuses: AtomicBool,
    requests: AtomicUsize,
    fates: Mutex<BTreeMap<Fate, u64>>,
}

impl State {
    fn next(&self) -> Fate {
        let number = self.requests.fetch_add(1, Ordering::SeqCst);
        let fate = match () {
            () if self.refuses.load(Ordering::SeqCst) => Fate::Refused,
            () if self.fails.load(Ordering::SeqCst) => FAULTS[number % FAULTS.len()],
            () => Fate::Answered,
        };
        *self.fates.lock().unwrap().entry(fate).or_default() += 1;
        fate
    }
}

/// The server; it ends with the test.
pub(crate) struct Server {
    endpoint: String,
    provider: Provider,
    state: Arc<State>,
    _runtime: tokio::runtime::Runtime,
}

impl Server {
    /// Serves a folder, in which a bucket is made.
    pub(crate) fn start(provider: Provider, folder: &Path) -> Self {
        std::fs::create_dir(folder.join(BUCKET)).unwrap();
        let mut files = S3ServiceBuilder::new(s3s_fs::FileSystem::new(folder).unwrap());
        let service = match provider {
            Provider::Amazon => {
                // Requests with a wrong signature are refused.
                files.set_auth(SimpleAuth::from_single(KEY, SECRET));
                Service::Amazon(files.build())
            }
            Provider::Google => Service::Google(files.build()),
            Provider::Azure => Service::Azure(azure::Container::new(folder, BUCKET)),
        };
        let state = Arc::new(State::default());
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
        let endpoint = format!("http://{}", listener.local_addr().unwrap());
        runtime.spawn(serve(listener, service, Arc::clone(&state)));
        Self { endpoint, provider, state, _runtime: runtime }
    }

    /// From now on many requests fail.
    pub(crate) fn fail_often(&self) {
        self.state.fails.store(true, Ordering::SeqCst);
    }

    /// From now on all requests are refused.
    pub(crate) fn refuse_all(&self) {
        self.state.refuses.store(true, Ordering::SeqCst);
    }

    /// How many requests had which fate.
    pub(crate) fn fates(&self) -> BTreeMap<Fate, u64> {
        self.state.fates.lock().unwrap().clone()
    }

    /// The environment in which programs find the server.
    pub(crate) fn variables(&self) -> Vec<(String, String)> {
        variables(self.provider, &self.endpoint)
    }
}

/// The environment in which programs find a server.
pub(crate) fn variables(provider: Provider, endpoint: &str) -> Vec<(String, String)> {
    let variables: &[(&str, &str)] = match provider {
        Provider::Amazon => &[
            ("AWS_ENDPOINT_URL", endpoint),
            ("AWS_ALLOW_HTTP", "true"),
            ("AWS_ACCESS_KEY_ID", KEY),
            ("AWS_SECRET_ACCESS_KEY", SECRET),
        ],
        Provider::Google => {
            &[("GOOGLE_BASE_URL", endpoint), ("GOOGLE_ALLOW_HTTP", "true"), ("GOOGLE_BEARER_TOKEN", TOKEN)]
        }
        Provider::Azure => &[
            ("AZURE_STORAGE_ENDPOINT", endpoint),
            ("AZURE_ALLOW_HTTP", "true"),
            ("AZURE_STORAGE_ACCOUNT", azure::ACCOUNT),
            ("AZURE_STORAGE_KEY", azure::KEY),
        ],
    };
    variables.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
}

async fn serve(listener: TcpListener, service: Service, state: Arc<State>) {
    while let Ok((stream, _)) = listener.accept().await {
        let (service, state) = (service.clone(), Arc::clone(&state));
        let answering = service_fn(move |request: Request<Incoming>| {
            let (service, fate) = (service.clone(), state.next());
            async move { answer(&service, request, fate).await }
        });
        // The test or the client wishes connections to end: errors of theirs are none of the server's.
        tokio::spawn(async { http1::Builder::new().serve_connection(TokioIo::new(stream), answering).await.is_ok() });
    }
}

/// Answers a request; an error cuts the connection.
async fn answer(service: &Service, request: Request<Incoming>, fate: Fate) -> io::Result<Response<Answer>> {
    let cut = || io::Error::other("cut");
    if fate == Fate::CutBefore {
        return Err(cut());
    }
    if fate == Fate::Refused {
        return Ok(empty(StatusCode::SERVICE_UNAVAILABLE));
    }
    let mut request = request;
    let (parts, bytes) = match service {
        Service::Azure(container) => {
            let (parts, body) = request.into_parts();
            let body = body.collect().await.map_err(|_| cut())?.to_bytes();
            container.answer(&parts, &body).into_parts()
        }
        Service::Amazon(files) | Service::Google(files) => {
            if let Service::Google(_) = service {
                let headers = request.headers_mut();
                if headers.remove(AUTHORIZATION).is_none_or(|said| said != format!("Bearer {TOKEN}")) {
                    return Ok(empty(StatusCode::UNAUTHORIZED));
                }
                if headers.remove("x-goog-if-generation-match").is_some_and(|said| said == "0") {
                    headers.insert(IF_NONE_MATCH, HeaderValue::from_static("*"));
                }
            }
            let answered = files.call(request.map(s3s::Body::from)).await.map_err(|_| cut())?;
            let (mut parts, body) = answered.into_parts();
            parts.headers.insert("x-goog-generation", HeaderValue::from_static("1"));
            (parts, body.collect().await.map_err(|_| cut())?.to_bytes())
        }
    };
    if fate == Fate::CutAfter {
        return Err(cut());
    }
    let is_cut = fate == Fate::CutWithin && bytes.len() > 1;
    let bytes = if is_cut { bytes.slice(..bytes.len() / 2) } else { bytes };
    Ok(Response::from_parts(parts, Answer { bytes: Some(bytes), is_cut }))
}

fn empty(status: StatusCode) -> Response<Answer> {
    let mut response = Response::new(Answer { bytes: None, is_cut: false });
    *response.status_mut() = status;
    response
}

/// The body of an answer, perhaps the beginning of one.
struct Answer {
    bytes: Option<Bytes>,
    is_cut: bool,
}

impl Body for Answer {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<io::Result<Frame<Bytes>>>> {
        match self.bytes.take().filter(|bytes| !bytes.is_empty()) {
            Some(bytes) => Poll::Ready(Some(Ok(Frame::data(bytes)))),
            None if self.is_cut => Poll::Ready(Some(Err(io::Error::other("cut")))),
            None => Poll::Ready(None),
        }
    }
}
