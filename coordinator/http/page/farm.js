// What the page knows of the farm, kept up to date by the server's events, or by asking where there
// can be no stream.

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
  jobs = new Map();  // by id; of those that have ended only what was asked for
  workers = new Map();  // by name
  /** state: connecting, live, polling, lost or token (the server asks for one). */
  connection = {state: 'connecting', text: ''};
  server = undefined;
  generation = 0;  // of what is known: after a break all is asked for again

  #listeners = new Set();
  #changes = undefined;
  #wake = new AbortController();

  /** `listener({jobs: Set of ids, shape, workers, connection, generation})`, once a frame at most. `shape`:
   *  jobs came, went or changed their state. */
  onChange(listener) {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  #note(change) {
    if (!this.#changes) {
      this.#changes = {jobs: new Set(), shape: false, workers: false, connection: false, generation: false};
      requestAnimationFrame(() => {
        const changes = this.#changes;
        this.#changes = undefined;
        for (const listener of this.#listeners) listener(changes);
      });
    }
    change(this.#changes);
  }

  takeJob(job) {
    const known = this.jobs.get(job.id);
    const shape = known?.state !== job.state;
    // In place: lists refer to it.
    if (known) Object.assign(known, {error: undefined}, job);
    else this.jobs.set(job.id, job);
    this.#note(changes => {
      changes.jobs.add(job.id);
      changes.shape ||= shape;
    });
  }

  forget(id) {
    this.jobs.delete(id);
    this.#note(changes => {
      changes.jobs.add(id);
      changes.shape = true;
    });
  }

  takeWorker(worker) {
    this.workers.set(worker.name, worker);
    this.#note(changes => { changes.workers = true; });
  }

  #takeWorkers(workers) {
    this.workers = new Map(workers.map(worker => [worker.name, worker]));
    this.#note(changes => { changes.workers = true; });
  }

  #take(event, data) {
    if (event === 'job') this.takeJob(data);
    else if (event === 'forgotten') this.forget(data.id);
    else if (event === 'worker') this.takeWorker(data);
    else if (event === 'gone') {
      this.workers.delete(data.name);
      this.#note(changes => { changes.workers = true; });
    }
  }

  #say(state, text = '') {
    this.connection = {state, text};
    this.#note(changes => { changes.connection = true; });
  }

  #forgetAll() {
    this.jobs = new Map();
    this.workers = new Map();
    ++this.generation;
    this.#note(changes => { changes.shape = changes.workers = changes.generation = true; });
  }

  /** A page of jobs older than `before` (undefined: the newest), in `states` (empty: all). Gives where
   *  the next page begins, null after the last. Throws Problem. */
  async loadJobs(states, before) {
    const query = new URLSearchParams({limit: pageOfJobs});
    if (before !== undefined) query.set('before', before);
    if (states.length) query.set('state', states.join(','));
    const generation = this.generation;
    const {jobs, next} = await getJson('jobs?' + query);
    // Events that came meanwhile are newer than this answer.
    if (generation === this.generation) for (const job of jobs) if (!this.jobs.has(job.id)) this.takeJob(job);
    return next;
  }

  /** One job, with its history. Throws Problem. */
  async loadJob(id) {
    const job = await getJson('jobs/' + id);
    this.takeJob(job);
    return job;
  }

  /** Tries again at once. */
  wake() {
    this.#wake.abort();
    this.#wake = new AbortController();
  }

  /** For as long as the page lives. */
  async run() {
    let failures = 0;
    for (;;) {
      try {
        this.server = await getJson('server');
        failures = 0;
        await this.#stream();
      } catch (problem) {
        if (problem.status === 401) {
          this.#say('token', problem.message);
          await sleep(2 ** 31 - 1, this.#wake.signal);
        } else if (problem.status > 0 && this.server) {
          if (await this.#poll()) continue;
        }
      }
      if (this.connection.state === 'token') continue;
      const pause = Math.min(longestPause, 500 * 2 ** failures++);
      this.#say('lost', `connection lost, again in ${Math.ceil(pause / 1000)} s`);
      await sleep(pause, this.#wake.signal);
    }
  }

  #stream() {
    return listen('events', {
      opened: () => {
        this.#forgetAll();
        this.#say('live', 'live');
      },
      take: (event, data) => this.#take(event, data),
      signal: this.#wake.signal,
    });
  }

  /** Without a stream: the server has as many listeners as it wants. Returns true when it is time to
   *  try for a stream again, false when the server is gone. */
  async #poll() {
    if (this.connection.state !== 'polling') this.#forgetAll();
    for (const end = performance.now() + streamAgainAfter; performance.now() < end;) {
      try {
        const [newest, busy, workers] = await Promise.all([getJson('jobs?limit=100'),
          getJson('jobs?limit=1000&state=queued,running,paused,finishing'), allWorkers()]);
        this.#endedMeanwhile(busy);
        for (const job of [...busy.jobs, ...newest.jobs]) this.takeJob(job);
        this.#takeWorkers(workers);
        this.#say('polling', 'asking every 3 s');
      } catch {
        return false;
      }
      await sleep(pollEvery, this.#wake.signal);
    }
    return true;
  }

  /** Jobs that were unfinished and are not among those that still are. */
  #endedMeanwhile(busy) {
    if (busy.next !== null) return;
    const still = new Set(busy.jobs.map(job => job.id));
    for (const job of this.jobs.values()) {
      if (unfinished(job) && !still.has(job.id)) {
        this.loadJob(job.id).catch(problem => problem.status === 404 && this.forget(job.id));
      }
    }
  }

  summary() {
    let running = 0;
    let waiting = 0;
    let speed = 0;
    for (const job of this.jobs.values()) {
      if (job.state === 'queued') ++waiting;
      if (job.state !== 'running' && job.state !== 'finishing') continue;
      ++running;
      speed += job.samples_per_second;
    }
    return {running, waiting, speed, workers: this.workers.size};
  }
}
