// The custom element <catoptric-viewer src="scene.glb" method="auto">. Importing this file defines it.
import { open, show } from './catoptric.js';

const STYLE = `
  :host { display: block; position: relative; min-height: 200px; background: #1b1b1b; color: #ddd; }
  canvas { position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none; outline: none; }
  div { position: absolute; inset: 0; display: grid; place-content: center; padding: 1em; text-align: center;
    pointer-events: none; font: 15px sans-serif; }
  div:empty { display: none; }`;

/**
 * Attributes: `src` (an address or `builtin:NAME`), `method`, `settings` (of that method: `KEY=VALUE, KEY=VALUE`),
 * `against` (a second method: a split view), `camera` (name or index), `environment` (`studio` or `sky`), `samples`,
 * `order`, `processor` (`gpu` or `cpu`), `controls` (shows the panels). The first four may change at any time.
 * Events: `load` (detail: the scene's name), `sharp`, `message` and `error` (detail: their words).
 */
export class CatoptricViewer extends HTMLElement {
  static observedAttributes = ['src', 'method', 'settings', 'against'];

  #viewer;
  #words;

  connectedCallback() {
    const root = this.shadowRoot ?? this.attachShadow({ mode: 'open' });
    root.innerHTML = `<style>${STYLE}</style><canvas tabindex="0"></canvas><div role="alert">Loading...</div>`;
    this.#words = root.querySelector('div');
    this.#start(root.querySelector('canvas'));
  }

  disconnectedCallback() {
    this.#viewer?.end();
    this.#viewer = undefined;
  }

  async #start(canvas) {
    const say = (text) => { this.#words.textContent = text; };
    const value = (name) => this.getAttribute(name) ?? '';
    const options = { scene: value('src'), panels: this.hasAttribute('controls') ? '' : 'off' };
    for (const name of ['method', 'settings', 'against', 'camera', 'environment', 'samples', 'order', 'processor']) {
      options[name] = value(name);
    }
    try {
      const viewer = await show(canvas, options, say);
      if (!this.isConnected) return viewer.end();
      this.#viewer = viewer;
      viewer.listen((kind, detail) => this.#tell(kind, detail));
      say('');
    } catch (error) {
      say(error.message);
      this.#tell('error', error.message);
    }
  }

  #tell(kind, detail) {
    // Not while the program is at work, which a listener may call again.
    queueMicrotask(() => this.dispatchEvent(new CustomEvent(kind, { detail })));
  }

  attributeChangedCallback(name, before, now) {
    if (!this.#viewer || before === now) return;
    try {
      if (name === 'src') {
        open(this.#viewer, now ?? '').catch((error) => this.#tell('error', error.message));
      } else if (name === 'settings') {
        this.#viewer.configure(0, now ?? '');
      } else {
        this.#viewer.choose(name === 'method' ? 0 : 1, now ?? '');
      }
    } catch (error) {
      this.#tell('error', error.message);
    }
  }

  /** What is shown: scene, method, settings, size, eye and messages; undefined while nothing is. */
  get state() {
    return this.#viewer && JSON.parse(this.#viewer.state());
  }
}

customElements.define('catoptric-viewer', CatoptricViewer);
