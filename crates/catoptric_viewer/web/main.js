// The page of its own: one viewer, its state in the address: ?scene=URL&method=ID&set=KEY=VALUE&against=ID&camera=NAME.
import { show } from './catoptric.js';

const words = document.getElementById('words');
const query = new URLSearchParams(location.search);
const options = { ...Object.fromEntries(query), settings: query.getAll('set').join(', ') };
try {
  window.catoptric = await show(document.getElementById('view'), options, (text) => { words.textContent = text; });
  words.textContent = '';
} catch (error) {
  document.getElementById('view')?.remove();
  words.textContent = error.message;
  console.warn(error.cause ?? error);
}
