// The page's copy of the farm's state. Server-sent events keep it current, or polling if no stream is
// available.

import {getJson, listen} from './api.js';
import {unfinished} from './format.js';

const pageOfJobs = 500;
const pollEvery = 3000;  // ms
const streamAgainAfter = 30000;
const longestPause = 15000;

const sleep = (time, signal) => new Promise(resolve => {
  const timer = setTimeout(resolve, time);
  signal?.addEventListener('abort', () => {
    clearTimeout(timer);
    resolve();
  });
});

async function allWorkers() {
  const all = [];
  for (;;) {
    const {workers, total} = await getJson(`workers?limit=1000&offset=${all.length}`);
    all.push(...workers);
    if (!workers.length || all.length >= total) return all;
  }
}

export class Farm {
  jobs = new Map();  // by id; all unfinished jobs, and the ended jobs that were loaded
  workers = new Map();  // by name
  /** state: connecting, live, polling, lost or token (the server requires one). */
  connection = {state: 'connecting', text: ''};
  server = undefined;
  generation = 0;  // grows with each new connection, after which all data is loaded again

  #listeners = new Set();
  #changes = undefined;
  #wake = new AbortController();

  /** Calls `listener({jobs: Set of ids, shape, ended, workers, connection, generation})` after changes, at most once
   *  per frame. `shape`: jobs were added, removed or changed their state. `ended`: jobs that ended meanwhile. */
  onChange(listener) {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  #schedule(change) {
    if (!this.#changes) {
      this.#changes = {jobs: new Set(), shape: false, ended: [], workers: false, connection: false, generation: false};
      requestAnimationFrame(() => {
        const changes = this.#changes;
        this.#changes = undefined;
        for (const listener of this.#listeners) listener(changes);
      });
    }
    change(this.#changes);
  }

  updateJob(job) {
    const known = this.jobs.get(job.id);
    const shape = known?.state !== job.state;
    const ended = known && unfinished(known) && !unfinished(job);
    // Updates the object in place, because lists refer to it.
    if (known) Object.assign(known, {error: undefined, error_so_far: undefined, warning: undefined}, job);
    else this.jobs.set(job.id, job);
    this.#schedule(changes => {
      changes.jobs.add(job.id);
      changes.shape ||= shape;
      if (ended) changes.ended.push(job);
    });
  }

  removeJob(id) {
    this.jobs.delete(id);
    this.#schedule(changes => {
      changes.jobs.add(id);
      changes.shape = true;
    });
  }

  updateWorker(worker) {
    this.workers.set(worker.name, worker);
    this.#schedule(changes => { changes.workers = true; });
  }

  #replaceWorkers(workers) {
    this.workers = new Map(workers.map(worker => [worker.name, worker]));
    this.#schedule(changes => { changes.workers = true; });
  }

  #applyEvent(event, data) {
    if (event === 'job') this.updateJob(data);
    else if (event === 'forgotten') this.removeJob(data.id);
    else if (event === 'worker') this.updateWorker(data);
    else if (event === 'gone') {
      this.workers.delete(data.name);
      this.#schedule(changes => { changes.workers = true; });
    }
  }

  #setConnection(state, text = '') {
    this.connection = {state, text};
    this.#schedule(changes => { changes.connection = true; });
  }

  #clear() {
    this.jobs = new Map();
    this.workers = new Map();
    ++this.generation;
    this.#schedule(changes => { changes.shape = changes.workers = changes.generation = true; });
  }

  /** Loads a page of jobs. `parameters`: of GET /jobs. Returns the answer: {jobs, next, total}. Throws Problem. */
  async loadJobs(parameters) {
    const generation = this.generation;
    const answer = await getJson('jobs?' + new URLSearchParams({limit: pageOfJobs, ...parameters}));
    // Jobs that an event has updated since the request are newer than this answer.
    if (generation === this.generation) for (const job of answer.jobs) if (!this.jobs.has(job.id)) this.updateJob(job);
    return answer;
  }

  /** Loads and returns one job with its history. Throws Problem. */
  async loadJob(id) {
    const job = await getJson('jobs/' + id);
    this.updateJob(job);
    return job;
  }

  /** Connects again at once. */
  wake() {
    this.#wake.abort();
    this.#wake = new AbortController();
  }

  /** Keeps the connection. Never returns. */
  async run() {
    let failures = 0;
    for (;;) {
      try {
        this.server = await getJson('server');
        failures = 0;
        await this.#stream();
      } catch (problem) {
        if (problem.status === 401) {
          this.server = undefined;
          this.#clear();
          this.generation = 0;  // nothing is loaded
          this.#setConnection('token', problem.message);
          await sleep(2 ** 31 - 1, this.#wake.signal);
        } else if (problem.status > 0 && this.server) {
          if (await this.#poll()) continue;
        }
      }
      if (this.connection.state === 'token') continue;
      const pause = Math.min(longestPause, 500 * 2 ** failures++);
      this.#setConnection('lost', `connection lost, next attempt in ${Math.ceil(pause / 1000)} s`);
      await sleep(pause, this.#wake.signal);
    }
  }

  #stream() {
    return listen('events', {
      opened: () => {
        this.#clear();
        this.#setConnection('live', 'live');
      },
      take: (event, data) => this.#applyEvent(event, data),
      signal: this.#wake.signal,
    });
  }

  /** Polls, because the server accepts no more streams. Returns true when it is time to request a stream
   *  again, false when the server cannot be reached. */
  async #poll() {
    if (this.connection.state !== 'polling') this.#clear();
    for (const end = performance.now() + streamAgainAfter; performance.now() < end;) {
      try {
        const [newest, busy, workers] = await Promise.all([getJson('jobs?limit=100'),
          getJson('jobs?limit=1000&state=queued,running,paused,finishing'), allWorkers()]);
        this.#updateEnded(busy);
        for (const job of [...busy.jobs, ...newest.jobs]) this.updateJob(job);
        this.#replaceWorkers(workers);
        this.#setConnection('polling', 'polling every 3 s');
      } catch {
        return false;
      }
      await sleep(pollEvery, this.#wake.signal);
    }
    return true;
  }

  /** Loads jobs that were unfinished before and are not in `busy` now. */
  #updateEnded(busy) {
    if (busy.next !== null) return;
    const still = new Set(busy.jobs.map(job => job.id));
    for (const job of this.jobs.values()) {
      if (unfinished(job) && !still.has(job.id)) {
        this.loadJob(job.id).catch(problem => problem.status === 404 && this.removeJob(job.id));
      }
    }
  }

  /** Returns the numbers of the header. `speed`: what all workers have contributed in the last minute or, from
   *  an older server, the speed of the jobs, in samples per second. */
  summary() {
    let running = 0;
    let waiting = 0;
    let speed = 0;
    let contribution;
    for (const worker of this.workers.values()) {
      if (worker.contribution >= 0) contribution = (contribution ?? 0) + worker.contribution;
    }
    for (const job of this.jobs.values()) {
      if (job.frame !== undefined) continue;  // its series counts
      if (job.state === 'queued') ++waiting;
      if (job.state !== 'running' && job.state !== 'finishing') continue;
      ++running;
      speed += job.samples_per_second;
    }
    return {running, waiting, speed: contribution ?? speed, workers: this.workers.size};
  }
}
