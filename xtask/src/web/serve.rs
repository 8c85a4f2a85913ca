//! Serves the folder on this machine alone.

use anyhow::{Context, Result};
use std::path::{Component, Path, PathBuf};
use tiny_http::{Header, Request, Response, Server};

/// The usual port.
pub(super) const PORT: u16 = 8777;

/// Serves a folder until the program is ended.
pub(super) fn serve(folder: &Path, port: u16) -> Result<()> {
    let server = open(port)?;
    println!("http://127.0.0.1:{port}/ (Ctrl-C ends it)");
    answer(&server, folder);
    Ok(())
}

/// A server of this machine; port 0 stands for any that is free.
pub(super) fn open(port: u16) -> Result<Server> {
    let opened = Server::http(("127.0.0.1", port));
    opened.map_err(|error| anyhow::anyhow!("{error}")).with_context(|| format!("port {port} cannot be used"))
}

/// Answers all requests.
pub(super) fn answer(server: &Server, folder: &Path) {
    for request in server.incoming_requests() {
        // Browsers close what they no longer want: that is no failure of the server's.
        let _ = give(request, folder);
    }
}

fn give(request: Request, folder: &Path) -> std::io::Result<()> {
    let Some(content) = file(request.url(), folder).and_then(|path| Some((std::fs::read(&path).ok()?, path))) else {
        return request.respond(Response::from_string("there is no such file").with_status_code(404));
    };
    let (content, path) = content;
    let mut response = Response::from_data(content);
    // With the last two pages may share memory with their workers.
    let headers = [
        ("Content-Type", kind(&path)),
        ("Cache-Control", "no-cache"),
        ("Cross-Origin-Opener-Policy", "same-origin"),
        ("Cross-Origin-Embedder-Policy", "require-corp"),
    ];
    for (name, value) in headers {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    request.respond(response)
}

/// The file of an address; nothing outside the folder.
fn file(url: &str, folder: &Path) -> Option<PathBuf> {
    let name = url.split(['?', '#']).next()?.trim_start_matches('/');
    let name = Path::new(if name.is_empty() { "index.html" } else { name });
    let is_inside = name.components().all(|part| matches!(part, Component::Normal(_)));
    is_inside.then(|| folder.join(name))
}

fn kind(path: &Path) -> &'static str {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("glb") => "model/gltf-binary",
        Some("png") => "image/png",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_outside_the_folder_is_served() {
        let folder = Path::new("dist");
        assert_eq!(file("/?scene=a", folder), Some(folder.join("index.html")));
        assert_eq!(file("/scenes/a.toml", folder), Some(folder.join("scenes/a.toml")));
        assert_eq!((file("/../Cargo.toml", folder), file("//etc/passwd/..", folder)), (None, None));
    }
}
