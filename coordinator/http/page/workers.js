// The view of all workers, and of those that left. Administrators can drain and resume workers.

import {getJson} from './api.js';
import {ask, button, el, setClass, setText} from './dom.js';
import {count, duration, rate, whole} from './format.js';
import {VirtualTable} from './list.js';
import {command, leftRow, Poll, renewAges, workerLink} from './parts.js';
import {WorkerButtons} from './steer_worker.js';

const leftEvery = 10000;  // ms

/** Returns whether the worker traces now. A drained or idle worker keeps the speed of its last lease. */
export const traces = worker => worker.leases > 0 && ['ready', 'draining'].includes(worker.state);
const speedOf = worker => traces(worker) ? worker.samples_per_second : 0;
const contributionOf = worker => worker.contribution ?? speedOf(worker);

const columns = [
  {name: 'name', title: 'Worker', of: worker => worker.name},
  {name: 'host', title: 'Host', of: worker => worker.host},
  {name: 'state', title: 'State', of: worker => worker.state},
  {name: 'threads', title: 'Threads', of: worker => -worker.threads},
  {name: 'speed', title: 'Contribution', hint: 'Samples per second that the farm got from this worker in the last minute', of: worker => -contributionOf(worker)},
  {name: 'tracing-speed', title: 'While tracing', hint: 'Samples per second while the worker traces a lease', of: worker => -speedOf(worker)},
  {name: 'traces', title: 'Traces', hint: 'The job that the worker traces now', of: worker => worker.tracing?.job ?? Infinity},
  {name: 'leases', title: 'Leases', hint: 'Parts of pictures that the worker has been given to trace', of: worker => -worker.leases},
  {name: 'accepted', title: 'Results', hint: 'Leases that the worker has traced and the coordinator has accepted', of: worker => -worker.accepted},
  {name: 'silent', title: 'Last contact', of: worker => -worker.seconds_silent},
  {name: 'reason', title: 'Reason', of: worker => worker.reason}];

const names = new Intl.Collator('en', {numeric: true});
const compare = (a, b) => typeof a === 'string' ? names.compare(a, b) : a === b ? 0 : a - b;

/** Returns the elements that say how to start a worker. */
function howToJoin(server) {
  const {worker_command, loopback, keys} = server ?? {};
  if (!worker_command) return [el('p', {}, 'Start parray-worker on each machine.')];
  const hint = loopback ? 'This coordinator serves only its own machine. For workers on other machines, start it with keys and --coordinator \'tcp://*:7400\'.' :
    keys ? 'This farm has keys. Copy the key of the workers (worker.key) to each machine first.' : '';
  return [command(worker_command), ...hint ? [el('p', {class: 'hint'}, hint)] : []];
}

/** Returns the words that the URL searches for: "#/workers?q=drained". */
const wordsOfAddress = () => new URLSearchParams(location.hash.split('?')[1] ?? '').get('q');

export class WorkersView {
  title = 'Workers';
  #farm;
  #sort = columns[0];
  #reverse = false;
  #largest = 1;
  #left = '';
  #poll = new Poll(leftEvery, () => this.#loadLeft());

  constructor(farm) {
    this.#farm = farm;
    this.heads = columns.map(column => ({...column, title: button(column.title, () => this.#sortBy(column), {title: column.hint})}));
    this.table = new VirtualTable({label: 'Workers', kind: 'workers', columns: [...this.heads, {name: 'act', title: el('span', {class: 'unseen'}, 'Action')}],
      make: row => this.#make(row), fill: (parts, worker) => this.#fill(parts, worker)});
    this.search = el('input', {type: 'search', placeholder: 'name, host or state', 'aria-label': 'Filter by name, host or state',
      oninput: () => this.#rebuild()});
    this.count = el('p', {class: 'count', role: 'status'});
    this.add = button('Add workers', () => this.#showHowToJoin(), {class: 'add'});
    this.empty = el('div', {class: 'empty', hidden: true});
    this.list = el('ol', {class: 'events scroll', tabindex: 0, 'aria-label': 'Workers that left'});
    this.leftPart = el('section', {class: 'part left-part', 'aria-label': 'Left in the last hour', hidden: true}, el('h2', {}, 'Left in the last hour'), this.list);
    this.element = el('section', {class: 'view list workers-list', 'aria-labelledby': 'workers-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'workers-title', tabindex: -1}, 'Workers'), this.search, this.count, el('div', {class: 'actions'}, this.add)),
      this.table.element, this.empty, this.leftPart);
    this.#showSort();
  }

  show() {
    const words = wordsOfAddress();
    if (words !== null) this.search.value = words;
    this.#poll.start();
    this.#rebuild();
  }

  hide() {
    this.#poll.stop();
  }

  update(changes) {
    if (changes.generation) this.#poll.start();
    if (changes.workers || changes.generation || changes.connection) this.#rebuild();
  }

  #sortBy(column) {
    this.#reverse = column === this.#sort && !this.#reverse;
    this.#sort = column;
    this.#showSort();
    this.#rebuild();
  }

  #showSort() {
    const sample = {name: '', host: '', state: '', reason: ''};
    for (const [i, head] of [...this.table.head.children].entries()) {
      if (!columns[i]) continue;
      const text = typeof columns[i].of(sample) === 'string';
      const order = text !== this.#reverse ? 'ascending' : 'descending';
      head.setAttribute('aria-sort', columns[i] === this.#sort ? order : 'none');
    }
  }

  #rebuild() {
    const wanted = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const all = [...this.#farm.workers.values()];
    const workers = wanted.length ? all.filter(worker => {
      const text = `${worker.name}\n${worker.host}\n${worker.state}`.toLowerCase();
      return wanted.every(word => text.includes(word));
    }) : all;
    const of = this.#sort.of;
    const sign = this.#reverse ? -1 : 1;
    workers.sort((a, b) => sign * compare(of(a), of(b)) || names.compare(a.name, b.name));
    this.#largest = all.reduce((most, worker) => Math.max(most, contributionOf(worker)), 1);
    this.table.set(workers);
    this.#showCount(wanted.length ? workers.length : undefined, all);
    const empty = all.length === 0 && this.#farm.generation > 0;
    if (empty) this.empty.replaceChildren(el('p', {}, 'No workers are connected. Start one on each machine:'), ...howToJoin(this.#farm.server));
    this.empty.hidden = !empty;
    this.add.hidden = empty;
    this.table.element.hidden = empty;
  }

  #showCount(found, all) {
    const threads = all.reduce((sum, worker) => sum + worker.threads, 0);
    const others = new Map();
    for (const {state} of all) if (state !== 'ready') others.set(state, (others.get(state) ?? 0) + 1);
    setText(this.count, found !== undefined ? `${found} of ${all.length}` : [`${all.length} ${all.length === 1 ? 'worker' : 'workers'}, ${whole(threads)} ${threads === 1 ? 'thread' : 'threads'}`,
      ...[...others].map(([state, number]) => `${number} ${state}`)].join(', '));
  }

  #showHowToJoin() {
    ask('Add workers', close => [el('h2', {}, 'Add workers'), el('p', {}, 'Run on each machine:'), ...howToJoin(this.#farm.server),
      el('div', {class: 'answers'}, button('Close', () => close(), {autofocus: true}))]);
  }

  async #loadLeft() {
    let left = [];
    try {
      ({left = []} = await getJson('farm'));
    } catch {
      // an older coordinator does not know them
    }
    const content = JSON.stringify(left);
    if (content !== this.#left) this.list.replaceChildren(...left.map(leftRow));
    this.#left = content;
    this.leftPart.hidden = !left.length;
    renewAges(this.list);
  }

  #make(row) {
    const parts = {};
    for (const {name} of [...columns, {name: 'act'}]) {
      parts[name] = el('div', {class: name, role: 'cell'});
      row.append(parts[name]);
    }
    parts.link = el('a', {});
    parts.name.append(parts.link);
    parts.job = el('a', {});
    parts.traces.append(parts.job);
    parts.bar = el('span', {class: 'bar', 'aria-hidden': 'true'});
    parts.rate = el('span', {class: 'share'});
    parts.speed.append(parts.bar, parts.rate);
    parts.buttons = new WorkerButtons(this.#farm, {named: true});
    parts.act.append(parts.buttons.element);
    return parts;
  }

  #fill(parts, worker) {
    setText(parts.link, worker.name);
    parts.link.setAttribute('href', workerLink(worker.name).getAttribute('href'));
    setText(parts.host, worker.host);
    setText(parts.state, worker.state);
    setClass(parts.state, 'state ' + worker.state);
    setText(parts.threads, String(worker.threads));
    this.#fillWork(parts, worker);
    setText(parts.leases, whole(worker.leases));
    setText(parts.accepted, count(worker.accepted));
    setText(parts.silent, worker.seconds_silent < 10 ? 'now' : duration(worker.seconds_silent) + ' ago');
    setText(parts.reason, worker.reason);
    parts.reason.title = worker.reason;
    parts.buttons.show(worker);
  }

  /** Shows speed and contribution: none for a worker that traces nothing. */
  #fillWork(parts, worker) {
    const contribution = contributionOf(worker);
    parts.bar.classList.toggle('off', !(contribution > 0));
    parts.bar.style.setProperty('--share', contribution / this.#largest);
    const active = ['ready', 'draining'].includes(worker.state);
    setText(parts.rate, rate(contribution) || (active && !traces(worker) ? 'idle' : ''));
    setText(parts['tracing-speed'], rate(speedOf(worker)));
    const {tracing} = worker;
    setText(parts.job, tracing ? `job ${tracing.job}` : '');
    if (tracing) parts.job.setAttribute('href', `#/jobs/${tracing.job}`);
    parts.job.hidden = !tracing;
  }
}
