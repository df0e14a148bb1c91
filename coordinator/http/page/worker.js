// The view of one worker: its machine, what it traces, its last hour, its failures and its log.

import {getJson} from './api.js';
import {button, el, facts, setClass, setText} from './dom.js';
import {bytes, count, duration, moment, rate, whole} from './format.js';
import {age, ago, jobLink, Poll, reasonToLeave, renewAges} from './parts.js';
import {WorkerButtons} from './steer_worker.js';
import {TimeChart} from './time_chart.js';
import {traces} from './workers.js';

const refreshEvery = 5000;  // ms

/** Returns the name in the URL "#/workers/NAME". */
function nameOfAddress() {
  try {
    return decodeURIComponent(location.hash.replace(/^#\/workers\//, '').split('?')[0]);
  } catch {
    return '';
  }
}

export class WorkerView {
  #farm;
  #name = '';
  #worker;
  #content = '';
  #poll = new Poll(refreshEvery, () => this.#load());

  constructor(farm) {
    this.#farm = farm;
    this.heading = el('h1', {id: 'worker-title', tabindex: -1});
    this.state = el('span', {class: 'state'});
    this.steer = new WorkerButtons(farm, {done: () => this.#load()});
    this.trouble = el('p', {class: 'trouble', role: 'status', hidden: true});
    this.missing = el('div', {class: 'empty', hidden: true});
    this.facts = el('div', {});
    this.chart = new TimeChart({title: 'Samples per second', series: [{name: 'Samples per second', kind: 'area'}], format: count});
    this.failures = el('ol', {class: 'events'});
    this.failuresPart = el('section', {class: 'part', 'aria-label': 'Recent failures'}, el('h2', {}, 'Recent failures'), this.failures);
    this.refresh = button('Refresh log', () => this.#loadLog());
    this.logNote = el('p', {class: 'hint', role: 'status'});
    this.log = el('pre', {class: 'log', tabindex: 0, role: 'region', 'aria-label': 'Log'});
    this.logPart = el('section', {class: 'part log-part', 'aria-label': 'Log of the worker'},
      el('div', {class: 'part-head'}, el('h2', {}, 'Log'), this.logNote, this.refresh), this.log);
    this.body = el('div', {class: 'worker-body'},
      el('div', {class: 'column'}, this.trouble, this.facts, this.failuresPart),
      el('div', {class: 'column'}, this.chart.element, this.logPart));
    this.element = el('section', {class: 'view worker', 'aria-labelledby': 'worker-title'},
      el('div', {class: 'bar-of-view'}, el('a', {href: '#/workers', class: 'back', 'aria-label': 'All workers'}, '‹'), this.heading, this.state,
        this.steer.element), this.missing, this.body);
  }

  get title() {
    return this.#name;
  }

  show() {
    this.#name = nameOfAddress();
    this.#worker = this.#farm.workers.get(this.#name);
    this.#content = '';
    this.#setConnected(true);
    setText(this.heading, this.#name);
    this.missing.hidden = true;
    this.body.hidden = !this.#worker;
    this.failuresPart.hidden = true;
    this.chart.set({interval: 10, end: 0, lines: []});
    this.log.replaceChildren();
    this.#show();
    this.#poll.start();
    this.#loadLog();
  }

  hide() {
    this.#poll.stop();
  }

  update(changes) {
    if (changes.generation) this.show();
    const now = this.#farm.workers.get(this.#name);
    if (!changes.workers || !now) return;
    this.#worker = {...this.#worker, ...now};
    this.#show();
  }

  async #load() {
    const name = this.#name;
    let answer;
    try {
      answer = await getJson('workers/' + encodeURIComponent(name));
    } catch (problem) {
      if (name === this.#name && problem.status === 404) await this.#showUnconnected();
      return;
    }
    if (name !== this.#name) return;
    this.#setConnected(true);
    this.#worker = answer;
    this.missing.hidden = true;
    this.body.hidden = false;
    this.#show();
    const {history, recent_failures = []} = answer;
    this.chart.element.hidden = !history;
    if (history) this.chart.set({...history, lines: [history.samples_per_second ?? []]});
    this.failuresPart.hidden = !recent_failures.length;
    this.failures.replaceChildren(...recent_failures.map(({at, job, reason}) => el('li', {class: 'bad'}, age(at), el('span', {}, ...job ? [jobLink(job), ': '] : [], reason))));
  }

  /** Hides what only a connected worker has: its log and its last hour. */
  #setConnected(connected) {
    this.logPart.hidden = this.chart.element.hidden = !connected;
  }

  /** Shows a machine in quarantine without what only a connected worker has, or that there is no such worker. */
  async #showUnconnected() {
    if (!this.#farm.workers.has(this.#name)) return this.#showMissing();
    this.#setConnected(false);
    this.missing.hidden = true;
    this.body.hidden = false;
    this.#worker = this.#farm.workers.get(this.#name);
    this.#show();
  }

  async #showMissing() {
    let left;
    try {
      left = (await getJson('farm')).left?.find(({name}) => name === this.#name);
    } catch {
      // an older coordinator does not know it
    }
    const why = left ? `It left the farm ${ago(left.at)} (${reasonToLeave(left)}).` : 'It left the farm, or it never joined.';
    this.missing.replaceChildren(el('p', {}, `Worker ${this.#name} is not connected. ${why}`), el('a', {class: 'button', href: '#/workers'}, 'All workers'));
    this.missing.hidden = false;
    this.body.hidden = true;
    this.#worker = undefined;
    this.steer.show(undefined);
    this.state.hidden = true;
  }

  #show() {
    const worker = this.#worker;
    this.steer.show(worker);
    this.state.hidden = !worker;
    if (!worker) return;
    setText(this.state, worker.state);
    setClass(this.state, 'state ' + worker.state);
    setText(this.trouble, worker.reason ? `${worker.state}: ${worker.reason}` : '');
    this.trouble.hidden = !worker.reason;
    this.#showFacts(worker);
  }

  #showFacts(worker) {
    const content = JSON.stringify({...worker, history: undefined, seconds_silent: worker.seconds_silent < 10 ? 0 : worker.seconds_silent});
    if (content !== this.#content) this.facts.replaceChildren(facts(this.#pairs(worker)));
    this.#content = content;
    renewAges(this.body);
  }

  #pairs(worker) {
    const {tracing, contribution, load, processors, since, backoff_seconds, quarantine_ends} = worker;
    const job = tracing && this.#farm.jobs.get(tracing.job);
    return [
      ['Traces', tracing ? el('span', {}, jobLink(tracing.job), job?.name ? ` (${job.name})` : '', tracing.seconds > 0 ? `, for ${duration(tracing.seconds)}` : '') : 'nothing'],
      ['Contribution', contribution > 0 ? `${rate(contribution)} in the last minute` : ''],
      ['Speed while tracing', traces(worker) ? rate(worker.samples_per_second) : ''],
      ['Leases', `${whole(worker.leases)} held, ${whole(worker.accepted)} results accepted`],
      ['Failures', worker.failures > 0 ? whole(worker.failures) : worker.failures === 0 ? 'none' : ''],
      ['Gets leases in', backoff_seconds > 0 ? duration(backoff_seconds) : ''],
      ['Quarantine ends', quarantine_ends > 0 ? moment(quarantine_ends) : ''],
      ['Threads', processors > 0 ? `${whole(worker.threads)} on ${whole(processors)} processors` : whole(worker.threads)],
      ['Load', typeof load === 'number' ? `${load.toFixed(2)} in the last minute` : ''],
      ['Memory', worker.memory_bytes > 0 ? bytes(worker.memory_bytes) : ''],
      ['Host', worker.host], ['Address', worker.address], ['Machine', worker.machine], ['Version', worker.version],
      ['Connected since', since > 0 ? el('span', {}, moment(since), ', ', age(since)) : ''],
      ['Last contact', worker.seconds_silent < 10 ? 'now' : duration(worker.seconds_silent) + ' ago']];
  }

  async #loadLog() {
    const name = this.#name;
    this.refresh.disabled = true;
    setText(this.logNote, 'asking the worker…');
    let note = '';
    try {
      const {lines} = await getJson(`workers/${encodeURIComponent(name)}/log`);
      if (name !== this.#name) return;
      this.log.replaceChildren(lines.join('\n') || 'The log is empty.');
      this.log.hidden = false;
      this.log.scrollTop = this.log.scrollHeight;
      note = `last ${lines.length} lines`;
    } catch (problem) {
      note = problem.message;
      if (!this.log.textContent) this.log.hidden = true;
    } finally {
      this.refresh.disabled = false;
    }
    if (name === this.#name) setText(this.logNote, note);
  }
}
