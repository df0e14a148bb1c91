// The view of one job: its growing picture, its facts and its actions.

import {change, download, getJson} from './api.js';
import {button, confirm, el, facts, notify, setClass, setText} from './dom.js';
import {count, duration, errorOfGoal, estimate, goal, moment, percent, stem, unfinished, whole} from './format.js';
import {fetchMap} from './maps.js';
import {fetchPicture, noPicture} from './picture.js';
import {quickLookOf} from './quick_look.js';
import {Trend} from './trend.js';
import {Viewer} from './viewer.js';

const actionsOf = {  // the actions that each state permits
  queued: ['pause', 'cancel'], running: ['pause', 'cancel'], finishing: ['cancel'], paused: ['resume', 'cancel'],
  done: ['delete'], failed: ['requeue', 'delete'], cancelled: ['requeue', 'delete']};
const doneTexts = {pause: 'is paused', resume: 'is resumed', cancel: 'is cancelled', requeue: 'is queued again', delete: 'is deleted'};
const warnings = {
  cancel: 'Its workers stop. The samples are kept, and you can requeue the job.',
  delete: 'The server deletes the job and its picture. This cannot be undone.'};

export class JobView {
  #farm;
  #id = 0;
  #shown = new AbortController();
  #wake = () => {};
  #etag;
  #samples;
  #pixels = 0;
  #state = '';
  #frames = 0;  // number of listed frames
  #framesDone;

  constructor(farm) {
    this.#farm = farm;
    this.viewer = new Viewer();
    this.viewer.loadMap = kind => fetchMap(kind, this.#id, this.#shown.signal);
    this.heading = el('h1', {id: 'job-title', tabindex: -1});
    this.state = el('span', {});
    this.actions = el('div', {class: 'actions', role: 'group', 'aria-label': 'Job actions'});
    this.bar = el('div', {class: 'progress', role: 'progressbar', 'aria-label': 'Progress', 'aria-valuemin': 0, 'aria-valuemax': 100},
      el('span', {class: 'bar'}));
    this.now = el('p', {class: 'now'});
    this.trouble = el('p', {class: 'trouble', hidden: true});
    this.facts = el('div', {});
    this.trend = new Trend();
    this.priority = el('input', {type: 'number', min: 0, max: 100, required: true, 'aria-label': 'Priority, 0 to 100'});
    this.save = el('div', {class: 'actions', role: 'group', 'aria-label': 'Download'});
    this.history = el('ol', {class: 'history'});
    this.frames = el('div', {});
    this.report = el('div', {});
    this.steer = el('form', {class: 'inline', onsubmit: event => this.#setPriority(event)},
      el('label', {}, 'Priority ', this.priority), el('button', {type: 'submit'}, 'Set'));
    this.element = el('section', {class: 'view job', 'aria-labelledby': 'job-title'},
      el('div', {class: 'bar-of-view'}, el('a', {href: '#/jobs', class: 'back', 'aria-label': 'All jobs'}, '‹'), this.heading, this.state, this.actions),
      el('div', {class: 'halves'}, this.viewer.element,
        el('div', {class: 'panel'}, this.bar, this.now, this.trouble, this.facts, this.trend.element, this.steer, this.save, this.frames,
          el('details', {open: true}, el('summary', {}, 'History'), this.history), this.report)));
  }

  show(id) {
    this.#id = id;
    this.#shown = new AbortController();
    this.#etag = this.#samples = this.#framesDone = undefined;
    this.#pixels = this.#frames = 0;
    this.#state = '';
    this.viewer.clear();
    this.trend.clear();
    this.viewer.showMessage('');
    for (const part of [this.history, this.report, this.frames]) part.replaceChildren();
    setText(this.heading, `Job ${id}`);
    this.#loadDetails();
    this.#draw();
    this.#follow(this.#shown.signal);
  }

  hide() {
    this.#shown.abort();
    this.#wake();
  }

  get job() {
    return this.#farm.jobs.get(this.#id);
  }

  get title() {
    const job = this.job;
    if (!job) return `Job ${this.#id}`;
    return `${unfinished(job) ? percent(job.progress) : job.state}, ${job.name || 'job ' + job.id}`;
  }

  update(changes) {
    if (changes.generation) this.#loadDetails();
    if (this.job) {
      if (changes.jobs.has(this.#id)) this.#draw();
    } else if (changes.jobs.has(this.#id) && !changes.generation) {
      location.hash = '#/jobs';  // the job was deleted
    }
  }

  /** Loads history and frames, which only the answer for a single job contains. */
  async #loadDetails() {
    const id = this.#id;
    try {
      const job = await this.#farm.loadJob(id);
      if (id !== this.#id) return;
      this.#showHistory(job.events ?? []);
      if (job.frames) this.#showFrames(job.frame_list ?? [], true);
    } catch (problem) {
      if (id === this.#id) this.viewer.showMessage(problem.message);
    }
  }

  #draw() {
    const job = this.job;
    if (!job) return;
    setText(this.heading, `${job.id}  ${job.name || 'untitled'}`);
    setText(this.state, job.state);
    setClass(this.state, 'state ' + job.state);
    const share = job.state === 'done' ? 1 : job.progress;
    setClass(this.bar, 'progress ' + job.state);
    this.bar.firstChild.style.setProperty('--share', share);
    this.bar.setAttribute('aria-valuenow', Math.floor(share * 100));
    setText(this.now, this.#statusText(job));
    const trouble = [job.reason, job.flag].filter(Boolean).join(' ');
    setText(this.trouble, trouble);
    this.trouble.hidden = !trouble;
    this.#showFacts(job);
    const to = goal(job);
    this.trend.add(to ? to.now : job.error?.rmse, to?.asked);
    this.viewer.element.hidden = Boolean(job.frames);
    const more = job.frames && job.frames_done !== this.#framesDone;
    this.#framesDone = job.frames_done;
    if (this.#state && (more || job.state !== this.#state)) this.#loadDetails();
    if (job.state === this.#state) return;
    this.#state = job.state;
    this.#showActions(job);
    if (job.state === 'done' && !job.frames) this.#loadResults(job.id);
    this.#wake();
  }

  #statusText(job) {
    if (job.state === 'done') return 'done';
    const parts = [job.frames ? `${job.frames_done} of ${job.frames} frames` : percent(job.progress)];
    if (unfinished(job) && job.seconds_left >= 0) parts.push(duration(job.seconds_left) + ' left');
    if (job.state === 'running' && job.samples_per_second > 0) parts.push(count(job.samples_per_second) + ' samples/s');
    if (unfinished(job) && job.waits_for) parts.push('waiting: ' + job.waits_for);
    return parts.join('   ');
  }

  #showFacts(job) {
    const error = job.error ?? {};
    const known = value => value !== null && value !== undefined;
    const to = goal(job);
    const pairs = [
      ['Picture', job.width ? `${job.width} × ${job.height} pixels` : ''],
      ['Samples', job.samples_per_pixel ?
        `${this.#samples ? count(this.#samples / this.#pixels) + ' of ' : ''}${whole(job.samples_per_pixel)} per pixel, ${job.sampler}` : ''],
      ['Error', known(error.rmse) ? `${estimate(error.rmse)} (${estimate(error.low)} to ${estimate(error.high)})` : job.frames ? '' : 'unknown'],
      ['Half-width', known(error.half_width_p50) ? `median ${estimate(error.half_width_p50)}, 99\u00a0% within ${estimate(error.half_width_p99)}` : ''],
      ['Target', to ? `${to.kind} ${errorOfGoal(job)}` : ''],
      ['User', job.user],
      ['Priority', unfinished(job) ? '' : String(job.priority)]];
    if (job.series !== undefined && job.frame !== undefined) {
      pairs.push(['Frame', el('a', {href: `#/jobs/${job.series}`}, `${job.frame} in series ${job.series}`)]);
    }
    const quick = quickLookOf(job.id);
    if (quick) pairs.push(['Quick look', el('a', {href: `#/jobs/${quick}`}, `job ${quick}`)]);
    const fresh = facts(pairs);
    if (!this.facts.firstChild?.isEqualNode(fresh)) this.facts.replaceChildren(fresh);
    if (document.activeElement !== this.priority) this.priority.value = job.priority;
    this.steer.hidden = !unfinished(job);
  }

  #showActions(job) {
    const had = this.actions.contains(document.activeElement);
    this.actions.replaceChildren(...(actionsOf[job.state] ?? []).map(word =>
      button(word[0].toUpperCase() + word.slice(1), () => this.act(word), {class: warnings[word] ? 'danger' : undefined})));
    if (had) (this.actions.querySelector('button:not(.danger)') ?? this.heading).focus();
    const name = `${stem(job.name || 'job')}-${job.id}`;
    const saving = (text, path, file) => button(text, async event => {
      event.target.disabled = true;
      try {
        await download(`jobs/${job.id}/${path}`, file);
      } catch (problem) {
        notify(problem.message, 'error');
      }
      event.target.disabled = false;
    });
    this.save.replaceChildren(...job.frames ? [] : [saving('PNG', 'image.png', name + '.png'), saving('EXR', 'image.exr', name + '.exr'),
      ...job.state === 'done' ? [saving('Error map', 'error.png', name + '-error.png'), saving('Report', 'report', name + '.json')] : []]);
    if (this.save.childElementCount) this.save.prepend(el('span', {}, 'Download'));
  }

  /** Performs an action: pause, resume, cancel, requeue or delete. */
  async act(word) {
    const job = this.job;
    if (!job || !actionsOf[job.state]?.includes(word)) return;
    const capital = word[0].toUpperCase() + word.slice(1);
    if (warnings[word] && !await confirm(`${capital} job ${job.id}?`, warnings[word], 'Keep job', `${capital} job`)) return;
    try {
      if (word === 'delete') {
        await change('DELETE', `jobs/${job.id}`);
        this.#farm.removeJob(job.id);
      } else {
        this.#farm.updateJob(await change('POST', `jobs/${job.id}/${word}`));
      }
      notify(`Job ${job.id} ${doneTexts[word]}.`);
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }

  /** Pauses or resumes the job (key p). */
  pauseOrResume() {
    this.act(this.job?.state === 'paused' ? 'resume' : 'pause');
  }

  async #setPriority(event) {
    event.preventDefault();
    try {
      this.#farm.updateJob(await change('PUT', `jobs/${this.#id}/priority`, {priority: this.priority.valueAsNumber}));
      notify(`Job ${this.#id} has priority ${this.priority.value}.`);
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }

  /** Updates the picture as long as it can change and the view is shown. */
  async #follow(signal) {
    while (!signal.aborted) {
      const begin = performance.now();
      const last = await this.#refresh(signal);
      if (signal.aborted) return;
      // Updates take at most a fifth of the time.
      const pause = last ? 2 ** 31 - 1 : Math.max(1000, 4 * (performance.now() - begin));
      await new Promise(resolve => {
        const timer = setTimeout(resolve, pause);
        this.#wake = () => {
          clearTimeout(timer);
          resolve();
        };
      });
    }
  }

  /** Updates the picture once. Returns true if it cannot change before the job's state does. */
  async #refresh(signal) {
    const job = this.job;
    if (!job || document.hidden || this.#farm.connection.state === 'lost') return false;
    if (job.frames) return true;
    try {
      const picture = await fetchPicture(job, this.#etag, signal);
      if (!picture || signal.aborted) return job.state === 'done';
      this.#etag = picture.etag;
      this.#samples = picture.samples;
      this.#pixels = picture.width * picture.height;
      this.viewer.showMessage('');
      const quick = await this.#quickLook(job, signal);
      if (signal.aborted) return true;
      // A finished quick look shows more than a picture of single samples.
      const early = quick && !quick.partial && picture.samples < 2 * this.#pixels;
      this.viewer.show(early ? noPicture(job) : picture, quick);
      this.#showFacts(job);
      return !picture.partial;
    } catch (problem) {
      if (signal.aborted) return true;
      if (!this.#etag) await this.#showNothing(job, problem, signal);
      return !unfinished(job);
    }
  }

  /** Shows the quick look, if there is one, because the job has no picture yet. */
  async #showNothing(job, problem, signal) {
    const quick = unfinished(job) ? await this.#quickLook(job, signal) : undefined;
    if (signal.aborted) return;
    if (quick) this.viewer.show(noPicture(job), quick);
    this.viewer.showMessage(!unfinished(job) ? problem.message : quick ? '' : 'No picture yet.');
  }

  #quickPicture;
  async #quickLook(job, signal) {
    const quick = quickLookOf(job.id);
    if (!quick || job.state === 'done') return undefined;
    if (this.#quickPicture?.of !== job.id || this.#quickPicture.picture.partial) {
      try {
        this.#quickPicture = {of: job.id, picture: await fetchPicture(await getJson('jobs/' + quick, signal), undefined, signal)};
      } catch {
        return undefined;
      }
    }
    return this.#quickPicture.picture;
  }

  /** Loads the report and the error map of a done job. */
  async #loadResults(id) {
    const here = () => id === this.#id && !this.#shown.signal.aborted;
    try {
      const report = await getJson(`jobs/${id}/report`);
      if (here()) this.#showReport(report);
      const error = await fetchMap('error', id, this.#shown.signal);
      if (here()) this.viewer.showMap(error);
    } catch (problem) {
      if (here()) notify(problem.message, 'error');
    }
  }

  #showHistory(events) {
    this.history.replaceChildren(...events.map(({at, what}) => el('li', {},
      el('time', {datetime: new Date(at * 1000).toISOString()}, moment(at)), el('span', {}, what))));
  }

  #showReport(report) {
    const pairs = [];
    const flatten = (value, path) => {
      if (Array.isArray(value) && value.some(item => item instanceof Object)) pairs.push([path, `${value.length} entries`]);
      else if (Array.isArray(value)) pairs.push([path, value.join(', ')]);
      else if (value instanceof Object) for (const [name, inner] of Object.entries(value)) flatten(inner, path ? `${path}.${name}` : name);
      else pairs.push([path, value === null ? 'unknown' : typeof value === 'number' && !Number.isInteger(value) ? String(Number(value.toPrecision(6))) : String(value)]);
    };
    flatten(report, '');
    const list = facts(pairs);
    list.classList.add('raw');
    this.report.replaceChildren(el('details', {open: true}, el('summary', {}, 'Report'), list));
  }

  #showFrames(frames, begin) {
    if (begin) {
      this.frames.replaceChildren(el('h2', {}, 'Frames'), el('ol', {class: 'frames'}));
      this.#frames = 0;
    }
    this.frames.querySelector('.more')?.remove();
    this.frames.querySelector('ol').append(...frames.map(({frame, job, state, reason}) => el('li', {class: 'state ' + state},
      el('span', {}, `${frame} `), job ? el('a', {href: `#/jobs/${job}`}, state) : state, reason ? ' ' + reason : '')));
    this.#frames += frames.length;
    const last = frames.at(-1)?.frame;
    if (last === undefined || this.#frames >= this.job.frames) return;
    this.frames.append(button('More frames', async () => {
      const more = await getJson(`jobs/${this.#id}?from_frame=${last + 1}`);
      this.#showFrames(more.frame_list ?? [], false);
    }, {class: 'more'}));
  }
}
