// The view of all workers. Administrators can drain and resume them.

import {change} from './api.js';
import {button, confirm, el, notify, setClass, setText} from './dom.js';
import {count, duration, rate, whole} from './format.js';
import {VirtualTable} from './list.js';

const columns = [
  {name: 'name', title: 'Worker', of: worker => worker.name},
  {name: 'host', title: 'Host', of: worker => worker.host},
  {name: 'state', title: 'State', of: worker => worker.state},
  {name: 'threads', title: 'Threads', of: worker => -worker.threads},
  {name: 'speed', title: 'Speed', of: worker => -worker.samples_per_second},
  {name: 'leases', title: 'Leases', of: worker => -worker.leases},
  {name: 'accepted', title: 'Results', of: worker => -worker.accepted},
  {name: 'silent', title: 'Last contact', of: worker => -worker.seconds_silent},
  {name: 'reason', title: 'Reason', of: worker => worker.reason}];

const names = new Intl.Collator('en', {numeric: true});
const compare = (a, b) => typeof a === 'string' ? names.compare(a, b) : a - b;

export class WorkersView {
  title = 'Workers';
  #farm;
  #sort = columns[0];
  #fastest = 1;

  constructor(farm) {
    this.#farm = farm;
    this.heads = columns.map(column => ({...column, title: button(column.title, () => this.#sortBy(column))}));
    this.table = new VirtualTable({label: 'Workers', kind: 'workers', columns: [...this.heads, {name: 'act', title: el('span', {class: 'unseen'}, 'Action')}],
      make: row => this.#make(row), fill: (parts, worker) => this.#fill(parts, worker)});
    this.search = el('input', {type: 'search', placeholder: 'name or host', 'aria-label': 'Filter by name or host',
      oninput: () => this.#rebuild()});
    this.count = el('p', {class: 'count', role: 'status'});
    this.empty = el('div', {class: 'empty', hidden: true}, el('p', {}, 'No workers are connected. Start one on each machine:'),
      el('pre', {}, 'parray-worker --coordinator tcp://HOST:7400'));
    this.element = el('section', {class: 'view list', 'aria-labelledby': 'workers-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'workers-title', tabindex: -1}, 'Workers'), this.search, this.count),
      this.table.element, this.empty);
    this.#sortBy(columns[0]);
  }

  show() {
    this.#rebuild();
  }

  update(changes) {
    if (changes.workers || changes.generation) this.#rebuild();
  }

  #sortBy(column) {
    this.#sort = column;
    for (const [i, head] of [...this.table.head.children].entries()) {
      if (columns[i]) head.setAttribute('aria-sort', columns[i] === column ? 'ascending' : 'none');
    }
    this.#rebuild();
  }

  #rebuild() {
    const wanted = this.search.value.toLowerCase();
    const all = [...this.#farm.workers.values()];
    const workers = wanted ? all.filter(worker =>
      (worker.name + '\n' + worker.host).toLowerCase().includes(wanted)) : all;
    const of = this.#sort.of;
    workers.sort((a, b) => compare(of(a), of(b)) || names.compare(a.name, b.name));
    this.#fastest = workers.reduce((most, worker) => Math.max(most, worker.samples_per_second), 1);
    this.table.set(workers);
    const threads = all.reduce((sum, worker) => sum + worker.threads, 0);
    setText(this.count, wanted ? `${workers.length} of ${all.length}` :
      `${all.length} ${all.length === 1 ? 'worker' : 'workers'}, ${threads} threads`);
    this.empty.hidden = all.length > 0 || !this.#farm.generation;
    this.table.element.hidden = !this.empty.hidden;
  }

  #make(row) {
    const parts = {};
    for (const {name} of [...columns, {name: 'act'}]) {
      parts[name] = el('div', {class: name, role: 'cell'});
      row.append(parts[name]);
    }
    parts.bar = el('span', {class: 'bar', 'aria-hidden': 'true'});
    parts.rate = el('span', {class: 'share'});
    parts.speed.append(parts.bar, parts.rate);
    parts.button = button('', () => this.#steer(parts.worker));
    parts.act.append(parts.button);
    return parts;
  }

  #fill(parts, worker) {
    parts.worker = worker;
    setText(parts.name, worker.name);
    setText(parts.host, worker.host);
    setText(parts.state, worker.state);
    setClass(parts.state, 'state ' + worker.state);
    setText(parts.threads, String(worker.threads));
    parts.bar.style.setProperty('--share', worker.samples_per_second / this.#fastest);
    setText(parts.rate, rate(worker.samples_per_second) || 'idle');
    setText(parts.leases, whole(worker.leases));
    setText(parts.accepted, count(worker.accepted));
    setText(parts.silent, worker.seconds_silent < 10 ? 'now' : duration(worker.seconds_silent) + ' ago');
    setText(parts.reason, worker.reason);
    setText(parts.button, worker.state === 'ready' ? 'Drain' : 'Resume');
    const label = `${parts.button.textContent} ${worker.name}`;
    if (parts.button.getAttribute('aria-label') !== label) parts.button.setAttribute('aria-label', label);
    parts.button.hidden = this.#farm.server?.role === 'client';
  }

  async #steer(worker) {
    const drain = worker.state === 'ready';
    const host = el('input', {type: 'checkbox'});
    const yes = await confirm(`${drain ? 'Drain' : 'Resume'} ${worker.name}?`, drain ?
      'It finishes its leases and gets no more.' : 'It gets leases again.', 'Cancel', drain ? 'Drain' : 'Resume',
    el('label', {class: 'check'}, host, `Apply to all workers of host ${worker.host}`));
    if (!yes) return;
    const name = host.checked ? worker.host : worker.name;
    try {
      const query = host.checked ? '?host=true' : '';
      const {workers} = await change('POST', `workers/${encodeURIComponent(name)}/${drain ? 'drain' : 'readmit'}${query}`);
      for (const changed of workers) this.#farm.updateWorker(changed);
      notify(`${name} ${drain ? 'gets no more leases' : 'gets leases again'}`);
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }
}
