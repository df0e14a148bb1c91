// Small parts that several views of the farm share: ages, a copy button, regular requests.

import {button, el, notify, setText} from './dom.js';
import {moment} from './format.js';

/** Formats the time since `at` (seconds since 1970): "now", "3 min ago". */
export function ago(at, now = Date.now() / 1000) {
  const age = Math.max(0, now - at);
  if (age < 5) return 'now';
  if (age < 59.5) return `${Math.round(age)} s ago`;
  if (age < 3570) return `${Math.round(age / 60)} min ago`;
  if (age < 48 * 3600) return `${Math.round(age / 3600)} h ago`;
  return `${Math.round(age / 86400)} days ago`;
}

/** Creates an element that shows how long ago `at` was, and the exact time when the pointer rests on it. */
export const age = at => el('time', {datetime: new Date(at * 1000).toISOString(), title: moment(at), 'data-at': at}, ago(at));

/** Updates all ages below `node`. */
export function renewAges(node) {
  for (const time of node.querySelectorAll('time[data-at]')) setText(time, ago(Number(time.dataset.at)));
}

export const workerLink = name => el('a', {href: '#/workers/' + encodeURIComponent(name)}, name);
export const jobLink = id => el('a', {href: `#/jobs/${id}`}, `job ${id}`);

/** Formats why a worker left: "lost: silent". */
export function reasonToLeave({lost, reason = ''}) {
  const word = lost ? 'lost' : 'left';
  return reason.startsWith(word) ? reason : [word, reason].filter(Boolean).join(': ');
}

/** Creates the row of a worker that left: when, name, host, and why. */
export const leftRow = worker => el('li', {class: worker.lost ? 'bad' : ''}, age(worker.at),
  el('span', {}, workerLink(worker.name), worker.host && worker.host !== worker.name ? ` of ${worker.host}` : '', `, ${reasonToLeave(worker)}`));

async function copy(text) {
  let copied = true;
  try {
    await navigator.clipboard.writeText(text);
  } catch {  // plain HTTP from another machine: the browser offers no clipboard
    const field = el('textarea', {class: 'unseen', readonly: true}, text);
    document.body.append(field);
    field.select();
    copied = document.execCommand('copy');
    field.remove();
  }
  notify(copied ? 'Copied' : 'The browser does not permit copying: select the text and press Ctrl+C');
}

/** Creates a line of text in the shape of a command, with a button that copies it. */
export const command = text => el('div', {class: 'command'}, el('code', {}, text),
  button('Copy', () => copy(text), {'aria-label': `Copy: ${text}`}));

/** Calls `load()` at once and then every `period` ms while a view is shown and the tab is visible. `load`
 *  handles its errors. */
export class Poll {
  #load;
  #period;
  #timer;
  constructor(period, load) {
    this.#load = load;
    this.#period = period;
  }
  start() {
    this.stop();
    const turn = async () => {
      if (!document.hidden) await this.#load();
      if (this.#timer === mine) this.#timer = mine = setTimeout(turn, this.#period);
    };
    let mine = this.#timer = setTimeout(turn, 0);
  }
  stop() {
    clearTimeout(this.#timer);
    this.#timer = undefined;
  }
}
