// Drains and resumes workers, after a question.

import {change} from './api.js';
import {button, confirm, el, notify, setAttribute} from './dom.js';

/** Returns whether the user may drain and resume workers: not before the server has said who the user is. */
export const maySteer = farm => Boolean(farm.server) && farm.server.role !== 'client';

const words = {
  drain: {label: 'Drain', path: 'drain', states: ['ready', 'backoff'], question: 'It finishes its leases and gets no more.',
    hint: 'Give this worker no more leases', done: 'gets no more leases'},
  resume: {label: 'Resume', path: 'readmit', states: ['backoff', 'draining', 'drained', 'quarantined'], question: 'It gets leases again.',
    hint: 'Give this worker leases again', done: 'gets leases again'}};

/** The buttons for a worker: Drain, Resume, or both for a worker that waits after a failure. */
export class WorkerButtons {
  #farm;
  #worker;

  /** `named`: the labels contain the name of the worker. `done()`: called after a button was used. */
  constructor(farm, {named = false, done = () => {}} = {}) {
    this.#farm = farm;
    this.named = named;
    this.buttons = Object.keys(words).map(word => {
      const node = button(words[word].label, () => steer(farm, this.#worker, word).then(done), {title: words[word].hint, hidden: true});
      return [word, node];
    });
    this.element = el('div', {class: 'actions'}, ...this.buttons.map(([, node]) => node));
  }

  /** `worker`: undefined without one. */
  show(worker) {
    this.#worker = worker;
    for (const [word, node] of this.buttons) {
      node.hidden = !worker || !maySteer(this.#farm) || !words[word].states.includes(worker.state);
      if (this.named && worker) setAttribute(node, 'aria-label', `${words[word].label} ${worker.name}`);
    }
  }
}

/** Asks, and then drains or resumes a worker or all workers of its host. */
async function steer(farm, worker, word) {
  const {label, question} = words[word];
  const host = el('input', {type: 'checkbox'});
  // A machine in quarantine without a worker has no host.
  const more = worker.host ? [el('label', {class: 'check'}, host, `Apply to all workers of host ${worker.host}`)] : [];
  if (!await confirm(`${label} ${worker.name}?`, question, 'Cancel', label, ...more)) return;
  const workers = await send(farm, worker, word, host.checked);
  const still = workers?.some(({state}) => ['draining', 'drained'].includes(state));
  if (word !== 'resume' || host.checked || !still) return;
  const all = await confirm(`Resume all workers of host ${worker.host}?`,
    `The whole host of ${worker.name} was drained, so this worker cannot be resumed alone.`, 'Cancel', 'Resume host');
  if (all) await send(farm, worker, word, true);
}

/** Sends the request, and says what has happened. Returns the changed workers, or undefined after an error. */
async function send(farm, worker, word, host) {
  const {path, done} = words[word];
  const name = host ? worker.host : worker.name;
  try {
    const {workers} = await change('POST', `workers/${encodeURIComponent(name)}/${path}${host ? '?host=true' : ''}`);
    for (const changed of workers) farm.updateWorker(changed);
    const still = word === 'resume' && workers.some(({state}) => ['draining', 'drained'].includes(state));
    if (!still) notify(`${name} ${done}`);
    return workers;
  } catch (problem) {
    notify(problem.message, 'error');
    return undefined;
  }
}
