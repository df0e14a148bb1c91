// The view "How is the farm?": its last hour, its users, its limits, and what has happened.

import {getJson} from './api.js';
import {el, setClass, setText} from './dom.js';
import {bytes, count, duration, percent, whole} from './format.js';
import {age, command, jobLink, leftRow, Poll, renewAges, workerLink} from './parts.js';
import {TimeChart} from './time_chart.js';

const refreshEvery = 5000;  // ms
const historyEvery = 10000;
const closeToLimit = 0.8;
const atLimit = 0.95;

const words = {joined: 'joined', left: 'left', lost: 'lost', quarantined: 'quarantined', readmitted: 'resumed', drained: 'drained', backoff: 'backoff',
  job_failed: 'failed', job_done: 'done', job_cancelled: 'cancelled', started: 'started'};
const bad = ['lost', 'quarantined', 'job_failed'];
const held = ['left', 'drained', 'backoff', 'job_cancelled'];
const groups = new Map([['all', () => true], ['problems', ({kind}) => bad.includes(kind) || kind === 'backoff'],
  ['workers', ({worker}) => worker !== undefined], ['jobs', ({job}) => job !== undefined]]);

const number = value => value % 1 && value < 100 ? value.toFixed(1) : whole(value);
const section = (title, ...children) => el('section', {class: 'part', 'aria-label': title}, el('h2', {}, title), ...children);
/** Returns [state, number] of the states that matter now, in a fixed order. */
const states = counts => ['running', 'finishing', 'queued', 'paused', 'failed', 'ready', 'backoff', 'draining', 'drained', 'quarantined']
  .filter(state => counts?.[state] > 0).map(state => [state, counts[state]]);

/** Returns the worker or job of an event as a link, and the rest of its text. */
function eventContent({kind, worker, job, text = ''}) {
  const subject = worker ?? (job === undefined ? '' : `job ${job}`);
  let rest = subject && text.startsWith(subject) ? text.slice(subject.length).replace(/^[\s:,]+/, '') : text;
  const word = words[kind] ?? kind;
  if (!rest.toLowerCase().includes(word)) rest = rest ? `${word}: ${rest}` : word;
  return [worker !== undefined ? workerLink(worker) : job !== undefined ? jobLink(job) : undefined, ' ' + rest];
}

function eventRow(event) {
  const look = bad.includes(event.kind) ? 'bad' : held.includes(event.kind) ? 'held' : ['joined', 'readmitted', 'job_done'].includes(event.kind) ? 'good' : '';
  return el('li', {class: look}, age(event.at), el('span', {}, ...eventContent(event)));
}

class Limit {
  constructor(name, advice) {
    this.advice = advice;
    this.text = el('span', {class: 'amount'});
    this.meter = el('span', {class: 'bar', 'aria-hidden': 'true'});
    this.hint = el('p', {class: 'advice', hidden: true});
    this.element = el('div', {class: 'limit'}, el('span', {class: 'title'}, name), this.text, this.meter, this.hint);
  }
  set({used = 0, most = 0} = {}) {
    this.element.hidden = !(most > 0);
    const share = used / most;
    setText(this.text, `${bytes(used)} of ${bytes(most)}, ${percent(share)}`);
    this.meter.style.setProperty('--share', Math.min(1, share));
    setClass(this.element, 'limit ' + (share >= atLimit ? 'full' : share >= closeToLimit ? 'close' : ''));
    this.hint.hidden = !(share >= closeToLimit);
    setText(this.hint, this.advice);
  }
}

class Users {
  constructor() {
    this.body = el('tbody');
    this.empty = el('p', {class: 'hint'}, 'No jobs yet.');
    const heads = [['User', 'name'], ['Processor time', 'used', 'Time of all threads that traced for this user'], ['Share', '', 'Part of the farm that this user gets, compared with others'],
      ['Open', '', 'Jobs that have not ended'], ['Done'], ['Failed'], ['Cancelled'], ['Mean wait', '', 'Mean time from submit to start']];
    this.table = el('table', {}, el('thead', {}, el('tr', {}, ...heads.map(([text, kind, title]) => el('th', {scope: 'col', class: kind || undefined, title}, text)))), this.body);
    this.element = section('Users', this.empty, el('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of users'}, this.table));
  }
  set(users = []) {
    const sum = users.reduce((total, user) => total + (user.thread_seconds ?? 0), 0);
    this.empty.hidden = users.length > 0;
    this.table.parentNode.hidden = !users.length;
    const known = [...users].sort((a, b) => (b.thread_seconds ?? 0) - (a.thread_seconds ?? 0));
    this.body.replaceChildren(...known.map(user => this.#row(user, sum)));
  }
  #row(user, sum) {
    const bar = el('span', {class: 'bar', 'aria-hidden': 'true'});
    const part = sum > 0 ? user.thread_seconds / sum : 0;
    bar.style.setProperty('--share', part);
    const cell = value => el('td', {}, typeof value === 'number' ? number(value) : '');
    const name = user.user ? el('a', {href: '#/jobs?user=' + encodeURIComponent(user.user)}, user.user) : 'without a key';
    return el('tr', {}, el('th', {scope: 'row', class: 'name'}, name),
      el('td', {class: 'used'}, el('span', {class: 'used-bar'}, bar, el('span', {}, percent(part)), el('span', {class: 'time'}, duration(user.thread_seconds ?? 0)))),
      cell(user.share), cell(user.open_jobs), cell(user.done_jobs), cell(user.failed_jobs), cell(user.cancelled_jobs),
      el('td', {}, typeof user.queue_seconds_mean === 'number' ? duration(user.queue_seconds_mean) : ''));
  }
}

class Events {
  #events = [];
  #shown = '';
  #group = 'all';
  constructor() {
    this.list = el('ol', {class: 'events scroll', tabindex: 0, 'aria-label': 'Events'});
    this.empty = el('p', {class: 'hint'});
    this.choice = el('fieldset', {class: 'choice'}, el('legend', {class: 'unseen'}, 'Filter events'), ...[...groups.keys()].map(name => el('label', {},
      el('input', {type: 'radio', name: 'event-group', value: name, checked: name === 'all', onchange: () => {
        this.#group = name;
        this.#show();
      }}), el('span', {}, name))));
    this.element = el('section', {class: 'part', 'aria-label': 'Recent events'}, el('div', {class: 'part-head'}, el('h2', {}, 'Events'), this.choice), this.empty, this.list);
  }
  set(events = []) {
    this.#events = events;
    this.#show();
  }
  #show() {
    const found = this.#events.filter(groups.get(this.#group));
    const content = JSON.stringify(found);
    if (content !== this.#shown) this.list.replaceChildren(...found.map(eventRow));
    this.#shown = content;
    this.list.hidden = !found.length;
    this.empty.hidden = found.length > 0;
    setText(this.empty, this.#group === 'all' ? 'Nothing has happened since the coordinator started.' : `No events about ${this.#group}.`);
  }
}

export class FarmView {
  title = 'Farm';
  #farm;
  #now;  // the last answer of GET /farm
  #history;
  #shown = '';  // of the workers that left
  #poll = new Poll(refreshEvery, () => this.#load());
  #historyPoll = new Poll(historyEvery, () => this.#loadHistory());

  constructor(farm) {
    this.#farm = farm;
    this.figures = el('dl', {class: 'figures'});
    this.storage = el('p', {class: 'trouble storage', role: 'alert', hidden: true});
    this.warning = el('div', {class: 'warning', role: 'status', hidden: true});
    this.problem = el('p', {class: 'trouble', hidden: true});
    this.speed = new TimeChart({title: 'Samples per second', series: [{name: 'Samples per second', kind: 'area'}], format: count});
    this.busy = new TimeChart({title: 'Busy threads', series: [{name: 'Busy', kind: 'area'}, {name: 'of', kind: 'ceiling'}], format: number, least: 2});
    this.queued = new TimeChart({title: 'Queued jobs', series: [{name: 'Queued', kind: 'area'}], format: number, least: 2});
    this.memory = new Limit('Memory', 'New jobs wait when the memory is full. Cancel jobs, or raise --memory of the coordinator.');
    this.disk = new Limit('Disk', 'When the disk is full, the coordinator deletes the oldest ended jobs. Delete jobs, or raise --max-disk of the coordinator.');
    this.users = new Users();
    this.events = new Events();
    this.left = el('ol', {class: 'events scroll', tabindex: 0, 'aria-label': 'Workers that left'});
    this.leftPart = section('Left in the last hour', this.left);
    this.content = el('div', {class: 'farm-content', hidden: true}, this.figures, el('div', {class: 'charts'}, this.speed.element, this.busy.element, this.queued.element),
      el('div', {class: 'parts'}, el('div', {class: 'column'}, this.users.element, section('Limits', this.memory.element, this.disk.element)),
        el('div', {class: 'column'}, this.events.element, this.leftPart)));
    this.version = el('p', {class: 'count'});
    this.element = el('section', {class: 'view farm', 'aria-labelledby': 'farm-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'farm-title', tabindex: -1}, 'Farm'), this.version),
      el('div', {class: 'farm-body'}, this.problem, this.storage, this.warning, this.content));
  }

  show() {
    this.#poll.start();
    this.#historyPoll.start();
  }

  hide() {
    this.#poll.stop();
    this.#historyPoll.stop();
  }

  update(changes) {
    if (changes.generation) this.show();
    if (changes.connection && this.#farm.connection.state === 'token') this.#clear();
  }

  #clear() {
    this.hide();
    this.#now = this.#history = undefined;
    this.content.hidden = this.storage.hidden = this.warning.hidden = this.problem.hidden = true;
    setText(this.version, '');
    this.figures.replaceChildren();
    for (const list of [this.users, this.events]) list.set([]);
    this.left.replaceChildren();
    for (const chart of [this.speed, this.busy, this.queued]) chart.set({interval: 10, end: 0, lines: []});
  }

  async #load() {
    try {
      this.#now = await getJson('farm');
      this.problem.hidden = true;
      this.#show();
    } catch (problem) {
      this.#fail(problem);
    }
  }

  #fail(problem) {
    if (problem.status === 401 || problem.status === 0) return;  // the header says so
    setText(this.problem, problem.status === 404 ? 'This coordinator does not describe the farm: it is older than this page.' : problem.message);
    this.problem.hidden = false;
  }

  async #loadHistory() {
    try {
      this.#history = await getJson('farm/history');
    } catch {
      return;  // GET /farm reports the problem
    }
    const {interval, end, samples_per_second, busy_threads = [], threads = [], queued} = this.#history;
    this.speed.set({interval, end, lines: [samples_per_second ?? []]});
    this.busy.set({interval, end, lines: [busy_threads, threads]});
    this.queued.element.hidden = !queued;
    if (queued) this.queued.set({interval, end, lines: [queued]});
    this.#showFigures();
  }

  #show() {
    const {storage, memory, disk, users, events, left = []} = this.#now;
    const {server} = this.#farm;
    this.content.hidden = false;
    setText(this.version, server ? [`ParRay ${server.version}`, server.worker_address].filter(Boolean).join(' at ') : '');
    this.storage.hidden = !storage;
    setText(this.storage, storage ? `The coordinator cannot store anything now: ${storage}` : '');
    this.#showWarning();
    this.#showFigures();
    this.memory.set(memory);
    this.disk.set(disk);
    this.users.set(users);
    this.events.set(events);
    this.leftPart.hidden = !left.length;
    const content = JSON.stringify(left);
    if (content !== this.#shown) this.left.replaceChildren(...left.map(leftRow));
    this.#shown = content;
    renewAges(this.element);
  }

  /** Shows what stops the farm: no workers, or workers in quarantine. */
  #showWarning() {
    const counts = this.#now.workers ?? {};
    const connected = Object.values(counts).reduce((sum, number) => sum + number, 0);
    const lines = [];
    if (!connected) {
      lines.push(el('p', {}, el('strong', {}, 'No workers are connected.'), this.#open() ? ' Jobs wait. Start a worker on each machine:' : ' Start one on each machine:'));
      const {worker_command} = this.#farm.server ?? {};
      lines.push(worker_command ? command(worker_command) : el('p', {}, el('a', {href: '#/workers'}, 'How to start a worker')));
    }
    if (counts.quarantined) {
      lines.push(el('p', {}, el('a', {href: '#/workers?q=quarantined'}, `${counts.quarantined} ${counts.quarantined === 1 ? 'worker is' : 'workers are'} quarantined`),
        ' because of wrong results.'));
    }
    this.warning.hidden = !lines.length;
    const text = lines.map(line => line.textContent).join('\n');
    if (this.warning.dataset.text !== text) this.warning.replaceChildren(...lines);
    this.warning.dataset.text = text;
  }

  #open() {
    const {queued = 0, running = 0, paused = 0, finishing = 0} = this.#now.jobs ?? {};
    return queued + running + paused + finishing;
  }

  #queueText() {
    const {seconds_left} = this.#now;
    if (!this.#open()) return 'empty';
    if (typeof seconds_left !== 'number' || seconds_left < 0) return 'unknown';
    return duration(seconds_left);
  }

  #showFigures() {
    if (!this.#now) return;
    const {jobs, workers, threads = 0, samples_per_second = 0} = this.#now;
    const speed = this.#now.contribution ?? samples_per_second;
    const busy = this.#history?.busy_threads?.at(-1);
    const list = (counts, view) => {
      const found = states(counts);
      return found.length ? found.flatMap(([state, number], i) => [i ? ' · ' : '',
        el('a', {href: view === 'jobs' ? `#/jobs?state=${state}` : `#/workers?q=${state}`}, `${whole(number)} ${state}`)]) : ['none'];
    };
    const figures = [['Speed', [speed > 0 ? count(speed) + ' samples/s' : 'idle']],
      ['Threads', [typeof busy === 'number' ? `${whole(Math.min(busy, threads))} of ${whole(threads)} busy` : whole(threads)]],
      ['Queue ends in', [this.#queueText()]], ['Workers', list(workers, 'workers')], ['Jobs', list(jobs, 'jobs')]];
    const text = JSON.stringify(figures.map(([, parts]) => parts.map(part => part.textContent ?? part)));
    if (this.figures.dataset.text === text) return;
    this.figures.dataset.text = text;
    this.figures.replaceChildren(...figures.map(([name, parts]) => el('div', {}, el('dt', {}, name), el('dd', {}, ...parts))));
  }
}
