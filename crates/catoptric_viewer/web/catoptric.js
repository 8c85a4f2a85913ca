// Loads the program once a page and shows viewers in canvases. All addresses are relative to this file, so that the
// folder works wherever it lies.

const LOST = 'The connection to the graphics processor was lost: please load the page again.';

let loading;

/** The module, compiled and run once; `say` is told how far it has come. */
function load(say) {
  loading ??= (async () => {
    if (typeof WebAssembly !== 'object') {
      throw new Error('This browser has no WebAssembly: please use a newer one.');
    }
    const program = await import('./catoptric_viewer.js');
    const bytes = await download(new URL('./catoptric_viewer_bg.wasm', import.meta.url), say);
    const module = await WebAssembly.compile(bytes);
    await program.default({ module_or_path: module });
    program.install_panic_hook();
    addEventListener('error', ({ error }) => {
      if (error instanceof WebAssembly.RuntimeError) {
        say(`The program has stopped because of an error: please load the page again. ${globalThis.catoptricPanic ?? error}`);
      }
    });
    return { program, module };
  })();
  return loading;
}

/** The bytes at an address. */
async function download(url, say = () => {}) {
  const response = await fetch(url).catch((cause) => {
    throw new Error(`${url} cannot be loaded: is there a connection, and does that site let other pages read it?`,
      { cause });
  });
  if (!response.ok) throw new Error(`${url} cannot be loaded: ${response.status} ${response.statusText}`);
  const length = Number(response.headers.get('Content-Length'));
  const parts = [];
  let done = 0;
  const reader = response.body.getReader();
  for (;;) {
    const { value, done: isOver } = await reader.read();
    if (isOver) break;
    parts.push(value);
    done += value.length;
    const name = url.toString().split('/').pop();
    say(length > done ? `Loading ${name}: ${Math.round(100 * done / length)} %` : `Loading ${name}...`);
  }
  const bytes = new Uint8Array(done);
  parts.reduce((at, part) => { bytes.set(part, at); return at + part.length; }, 0);
  return bytes;
}

/** A scene by its address, or `builtin:NAME`. */
async function fetched(options, say) {
  const { scene } = options;
  if (!scene || scene.startsWith('builtin:') || options.content) return options;
  const url = new URL(scene, document.baseURI);
  // Addresses of things in memory have their name behind the #.
  const name = url.hash.slice(1) || url.pathname.split('/').pop();
  return { ...options, scene: name, content: await download(url, say) };
}

/**
 * Shows a viewer in a canvas. Options: `scene` (an address or `builtin:NAME`), `method`, `settings` (of that method:
 * `KEY=VALUE, KEY=VALUE`), `against`, `camera`, `environment` (`studio` or `sky`), `samples`, `order`, `processor` (`gpu`
 * or `cpu` draws; else the better one). The result has `open(name, bytes)`, `choose(side, method)`, `configure(side, settings)`, `state()`, `widgets()`
 * and `pixels(side)`.
 */
export async function show(canvas, options = {}, say = () => {}) {
  const { program, module } = await load(say);
  const worker = new URL('./worker.js', import.meta.url).href;
  const start = await fetched(options, say);
  say('Starting...');
  // A canvas keeps the kind of its first context: a second try needs another one.
  const tries = options.canvas ? [options.canvas] : ['', 'webgl'];
  let last;
  for (const kind of tries) {
    // WebGL says so here, WebGPU to the program.
    canvas.addEventListener('webglcontextlost', () => say(LOST));
    try {
      return await program.Page.start(canvas, worker, module, { ...start, canvas: kind });
    } catch (error) {
      last = error;
      if (globalThis.catoptricPanic) break;
      const fresh = canvas.cloneNode(false);
      canvas.replaceWith(fresh);
      canvas = fresh;
    }
  }
  if (last instanceof Error) throw last;
  throw new Error('This program draws its window with WebGPU or WebGL 2, and this browser offers neither. Turn on '
    + 'hardware acceleration in the browser\'s settings, or try another browser.', { cause: last });
}

/** Opens a scene in a viewer by its address. */
export async function open(viewer, scene, say) {
  const { scene: name, content } = await fetched({ scene }, say);
  viewer.open(name, content);
}
