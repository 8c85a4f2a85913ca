// The studio: a second instance of the same compiled module, which draws.
import init, { StudioWorker, install_panic_hook } from './catoptric_viewer.js';

let studio;
let isRunning = false;
const waiting = [];
const channel = new MessageChannel();
let wake = () => {};
channel.port1.onmessage = () => wake();
// Lets messages in, sooner than a timer would.
const breathe = () => new Promise((done) => { wake = done; channel.port2.postMessage(0); });
const pause = (ms) => new Promise((done) => { setTimeout(done, ms); });

// A lock that is held as long as this worker lives: the page waits for it, as nothing else tells it of a worker that the
// browser has ended.
function holdLock() {
  const name = `catoptric studio ${Math.random()}`;
  const forEver = () => { postMessage(name); return new Promise(() => {}); };
  navigator.locks?.request(name, forEver).catch(() => {});
}

function fail(error) {
  studio = undefined;
  postMessage([undefined, globalThis.catoptricPanic ?? String(error)]);
}

async function run() {
  if (isRunning) return;
  isRunning = true;
  try {
    while (studio) {
      const rest = studio.turn();
      if (rest < 0) break;
      await (rest > 0 ? pause(rest) : breathe());
    }
  } catch (error) {
    fail(error);
  }
  isRunning = false;
}

function receive([text, bytes, isOtherWork]) {
  try {
    studio.receive(text, bytes, isOtherWork);
  } catch (error) {
    fail(error);
  }
}

onmessage = async ({ data }) => {
  if (data[0] instanceof WebAssembly.Module) {
    holdLock();
    try {
      await init({ module_or_path: data[0] });
      install_panic_hook();
      studio = await StudioWorker.start(data[1], (text, bytes) => postMessage([text, bytes], [bytes.buffer]), data[2]);
    } catch (error) {
      return fail(error);
    }
    waiting.splice(0).forEach(receive);
  } else if (studio) {
    receive(data);
  } else {
    waiting.push(data);
  }
  if (studio) run();
};
