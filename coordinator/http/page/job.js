// The view of one job or series: its growing picture or its frames, its facts and its actions.

import {getJson} from './api.js';
import {button, el, facts, notify, setClass, setText} from './dom.js';
import {moment, percent, unfinished} from './format.js';
import {fileOf, findQuickLook, JobActions} from './job_actions.js';
import {factsOf, hasErrorMap, hasPicture, headline, historyOf, waiting} from './job_facts.js';
import {mayControl, permits} from './job_rules.js';
import {fetchMap} from './maps.js';
import {fetchPicture, noPicture} from './picture.js';
import {jobLink, Poll, renewAges} from './parts.js';
import {quickLookOf} from './quick_look.js';
import {recipeOf, reportOf} from './report.js';
import {neighboursOf, Series} from './series.js';
import {Trend} from './trend.js';
import {Viewer} from './viewer.js';

const framesEvery = 2000;  // ms
const unlistedEvery = 4000;  // ms; events do not name frames
const agesEvery = 20000;  // ms; texts such as "3 min ago" change

const sentence = text => text && text[0].toUpperCase() + text.slice(1);

function whyNoPicture(job) {
  if (unfinished(job)) return 'No picture yet';
  return job.state === 'done' ? 'No picture: the coordinator no longer keeps it' : 'No picture: the job ended before its first samples, or the coordinator no longer keeps them';
}

export class JobView {
  #farm;
  #id = 0;
  #shown = new AbortController();
  #wake = () => {};
  #etag;
  #perPixel;  // mean samples per pixel of the shown picture
  #state = '';
  #framesDone;
  #workers;  // number of workers that traced the job, from its report
  #quick;  // number of the quick look
  #deleted;  // the job that this user has deleted
  #ages = 0;  // timers
  #later = 0;
  #poll = new Poll(unlistedEvery, () => this.#loadUnlisted());

  constructor(farm) {
    this.#farm = farm;
    this.viewer = new Viewer();
    this.viewer.loadMap = kind => fetchMap(kind, this.#id, this.#shown.signal);
    this.series = new Series(farm);
    this.todo = new JobActions(farm, job => { this.#deleted = job; });
    this.heading = el('h1', {id: 'job-title', tabindex: -1});
    this.state = el('span', {});
    this.neighbours = el('nav', {class: 'neighbours', 'aria-label': 'Frames', hidden: true});
    this.bar = el('div', {class: 'progress', role: 'progressbar', 'aria-label': 'Progress', 'aria-valuemin': 0, 'aria-valuemax': 100},
      el('span', {class: 'bar'}));
    this.now = el('p', {class: 'now'});
    this.waits = el('p', {class: 'waits'});
    this.warning = el('div', {class: 'notice long-run', role: 'status', hidden: true});
    this.reason = el('p', {});
    this.flag = el('p', {class: 'notice'});
    this.facts = el('div', {});
    this.trend = new Trend();
    this.history = el('ol', {class: 'history'});
    this.past = el('details', {open: true}, el('summary', {}, 'History'), this.history);
    this.report = el('div', {class: 'results'});
    this.missing = el('div', {class: 'empty', hidden: true});
    this.body = el('div', {class: 'halves'}, this.viewer.element, this.series.element,
      el('div', {class: 'panel', tabindex: 0, role: 'group', 'aria-label': 'Facts'}, el('div', {class: 'head-line'}, this.now, this.bar, this.waits),
        this.warning, this.reason, this.flag, this.series.side, this.facts, this.trend.element, this.todo.steer, this.todo.save, this.report, this.past));
    this.element = el('section', {class: 'view job', 'aria-labelledby': 'job-title'},
      el('div', {class: 'bar-of-view'}, el('a', {href: '#/jobs', class: 'back', 'aria-label': 'All jobs'}, '‹'), this.heading, this.state, this.neighbours,
        this.todo.element), this.body, this.missing);
  }

  show(id) {
    this.hide();
    this.#id = id;
    this.#shown = new AbortController();
    this.#clear();
    this.#loadDetails();
    this.#draw();
    this.#follow(this.#shown.signal);
    this.#ages = setInterval(() => renewAges(this.facts), agesEvery);
    this.#poll.start();
  }

  hide() {
    this.#shown.abort();
    clearInterval(this.#ages);
    this.#poll.stop();
    clearTimeout(this.#later);
    this.#later = 0;
    this.series.stop();
    this.#wake();
  }

  /** Removes everything of the job that was shown before. */
  #clear() {
    this.#etag = this.#perPixel = this.#framesDone = this.#workers = this.#quick = this.#quickPicture = undefined;
    this.#state = '';
    this.viewer.clear();
    this.viewer.element.hidden = false;
    this.#offerMaps({state: '', has_picture: false});
    this.series.clear();
    this.todo.clear();
    this.trend.clear();
    for (const part of [this.history, this.report, this.facts, this.waits, this.warning, this.neighbours]) part.replaceChildren();
    for (const part of [this.now, this.state, this.reason, this.flag]) setText(part, '');
    for (const part of [this.warning, this.reason, this.flag, this.bar, this.waits, this.past, this.neighbours, this.missing]) part.hidden = true;
    setClass(this.state, '');
    this.body.hidden = false;
    setText(this.heading, `Job ${this.#id}`);
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
      if (changes.jobs.has(this.#id) || changes.jobs.has(this.job.series)) this.#draw();
      if (this.job?.frames) {
        this.series.update(changes.jobs);
        this.todo.show(this.job, this.#knownOf(this.job));
      }
    } else if (changes.jobs.has(this.#id) && !changes.generation) {
      this.#showDeleted();
    }
  }

  #showDeleted() {
    const {id, frame, series} = this.#deleted ?? {};
    if (id === this.#id) location.hash = frame === undefined ? '#/jobs' : `#/jobs/${series}`;
    else this.#showMissing(`Job ${this.#id} was deleted.`);
  }

  /** Shows a message in the place of the job. */
  #showMissing(...lines) {
    this.#clear();
    this.body.hidden = true;
    this.missing.hidden = false;
    this.missing.replaceChildren(...lines.map(line => el('p', {}, line)), el('a', {class: 'button', href: '#/jobs'}, 'All jobs'));
  }

  /** Loads what only the answer for a single job contains: history, passes and frames. */
  async #loadDetails() {
    const {signal} = this.#shown;
    const id = this.#id;
    try {
      const job = await getJson('jobs/' + id, signal);
      if (signal.aborted) return;
      if (!this.missing.hidden) this.#clear();
      this.#farm.updateJob(job);
      this.#draw();
      this.#showHistory(historyOf(job.events ?? []));
      this.trend.setPasses(job.passes ?? []);
      if (job.frames) this.#showFrames(job);
      else if (job.frame !== undefined) this.#showSeriesOf(job);
      else if (!this.#quick && unfinished(job)) this.#findQuickLook(signal);
    } catch (problem) {
      if (signal.aborted) return;
      if (problem.status === 404) this.#showMissing(this.#state ? `Job ${id} was deleted.` : `Job ${id} does not exist. It was deleted, or never submitted.`);
      else if (problem.status > 0 && problem.status !== 401 && !this.job) this.#showMissing(problem.message);
    }
  }

  /** Loads what no event announces: an unfinished frame, and the frames of an unfinished series. */
  async #loadUnlisted() {
    const job = this.job;
    if (!job || !unfinished(job) || this.#farm.connection.state === 'lost') return;
    if (job.frame !== undefined || job.frames) await this.#loadDetails();
  }

  /** Loads the frames again: once for all frames that end within a few seconds. */
  #loadFramesSoon() {
    if (this.#framesDone === undefined || this.#later) return;
    this.#later = setTimeout(() => {
      this.#later = 0;
      this.#loadDetails();
    }, framesEvery);
  }

  #draw() {
    const job = this.job;
    if (!job) return;
    setText(this.heading, `${job.id}  ${job.name || 'untitled'}`);
    setText(this.state, job.state);
    setClass(this.state, 'state ' + job.state);
    this.#showProgress(job);
    this.#showTroubles(job);
    this.#showFacts(job);
    this.todo.show(job, this.#knownOf(job));
    const isSeries = Boolean(job.frames);
    this.trend.add(job.seconds_taken, job.samples_taken, job.error?.rmse, job.target_error);
    this.viewer.element.hidden = isSeries;
    this.#offerMaps(job);
    if (isSeries) this.series.show(job);
    if (this.#state && job.state !== this.#state) this.#loadDetails();
    else if (isSeries && job.frames_done !== this.#framesDone) this.#loadFramesSoon();
    this.#framesDone = job.frames_done;
    if (job.state === this.#state) return;
    this.#state = job.state;
    if (job.state === 'done' && hasPicture(job)) this.#loadResults(job);
    this.#wake();
  }

  /** Shows the frames of a series, and the actions that their states permit. */
  #showFrames(job) {
    this.series.show(job, job.frame_list ?? []);
    this.todo.show(job, this.#knownOf(job));
  }

  /** Returns what decides the actions on a series or on a frame, as for permits(). */
  #knownOf(job) {
    return {frames: job.frames ? this.series.states : undefined, series: this.#farm.jobs.get(job.series)};
  }

  #offerMaps(job) {
    this.viewer.disableMap('error', hasErrorMap(job) ? '' : 'not known yet');
    for (const kind of ['cost', 'workers']) this.viewer.disableMap(kind, hasPicture(job) ? '' : 'no samples yet');
  }

  #showProgress(job) {
    setText(this.now, headline(job, this.#workers));
    const untouched = job.state === 'queued' && !(job.progress > 0);
    this.bar.hidden = job.state === 'done' || untouched;
    setClass(this.bar, 'progress ' + job.state);
    this.bar.firstChild.style.setProperty('--share', job.progress);
    this.bar.setAttribute('aria-valuenow', Math.floor(job.progress * 100));
    const fresh = el('p', {}, ...waiting(job));
    if (fresh.innerHTML !== this.waits.innerHTML) this.waits.replaceChildren(...fresh.childNodes);
    this.waits.hidden = !this.waits.firstChild;
    // What a job waits for is all there is to say before its first sample.
    setClass(this.waits, untouched ? 'waits lead' : 'waits');
    this.now.hidden = untouched && !this.waits.hidden;
  }

  #showTroubles(job) {
    setText(this.reason, sentence(job.reason));
    setClass(this.reason, job.state === 'failed' ? 'trouble' : 'notice');
    this.reason.hidden = !job.reason;
    setText(this.flag, job.flag);
    this.flag.hidden = !job.flag;
    const warning = unfinished(job) && job.warning ? sentence(job.warning) : '';
    this.warning.hidden = !warning;
    const cancel = Boolean(warning) && mayControl(job, this.#farm.server) && permits(job, 'cancel');
    if ((this.warning.firstChild?.textContent ?? '') === warning && Boolean(this.warning.querySelector('button')) === cancel) return;
    this.warning.replaceChildren(...warning ? [el('p', {}, warning)] : []);
    if (cancel) this.warning.append(button('Cancel job', () => this.todo.act('cancel'), {class: 'danger'}));
  }

  #showFacts(job) {
    const quick = quickLookOf(job.id) ?? this.#quick;
    const fresh = facts([...factsOf(job, this.#perPixel, this.#farm.server), ['Quick look', quick ? jobLink(quick) : '']]);
    if (!this.facts.firstChild?.isEqualNode(fresh)) this.facts.replaceChildren(fresh);
  }

  async #findQuickLook(signal) {
    const found = quickLookOf(this.#id) ?? await findQuickLook(this.#farm, this.#id, signal);
    if (!found || signal.aborted) return;
    this.#quick = found;
    if (this.job) this.#showFacts(this.job);
    this.#wake();
  }

  /** Shows links to the frames before and after this one, and the actions that the state of their series permits. */
  async #showSeriesOf(job) {
    if (!this.neighbours.hidden && this.#farm.jobs.has(job.series)) return;
    const {signal} = this.#shown;
    try {
      const {before, after, series} = await neighboursOf(job, signal);
      if (signal.aborted) return;
      this.#farm.updateJob(series);
      const link = (id, text, label, key) => id === undefined ? el('span', {class: 'off', 'aria-hidden': 'true'}, text) :
        el('a', {href: `#/jobs/${id}`, 'aria-label': label, 'aria-keyshortcuts': key, title: `${label} (key ${key})`}, text);
      this.neighbours.replaceChildren(link(before, '‹', 'Previous frame', ','), el('a', {href: `#/jobs/${job.series}`}, `frame ${job.frame}`),
        link(after, '›', 'Next frame', '.'));
      this.neighbours.hidden = false;
    } catch {
      // The frame has no neighbours to show if its series cannot be read.
    }
  }

  /** Pauses or resumes the job (key p). */
  pauseOrResume() {
    this.todo.pauseOrResume();
  }

  /** Handles a key of this view. Returns true if it has a meaning here. */
  key(event) {
    if (!this.series.element.hidden) return this.series.key(event);
    const side = {',': 'first', '.': 'last'}[event.key];
    if (!side || this.neighbours.hidden) return false;
    const target = this.neighbours[side + 'Child'];
    if (target.href) location.hash = target.getAttribute('href');
    return true;
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
      if (!hasPicture(job)) {
        await this.#showNothing(job, signal);
        return !unfinished(job);
      }
      const picture = await fetchPicture(job, this.#etag, signal);
      if (!picture || signal.aborted) return !unfinished(job);
      const quick = await this.#quickLook(job, signal);
      if (signal.aborted) return true;
      this.#showPicture(job, picture, quick);
      return !picture.partial || !unfinished(job);
    } catch (problem) {
      if (signal.aborted) return true;
      if (!this.#etag) await this.#showNothing(job, signal, problem.status === 409 ? '' : problem.message);
      return !unfinished(job);
    }
  }

  #showPicture(job, picture, quick) {
    const pixels = picture.width * picture.height;
    this.#etag = picture.etag;
    this.#perPixel = picture.samples > 0 ? picture.samples / pixels : undefined;
    this.viewer.showMessage('');
    // A finished quick look shows more than a picture of single samples.
    const early = quick && !quick.partial && picture.samples < 2 * pixels;
    this.viewer.show(early ? noPicture(job) : picture, quick);
    this.#showFacts(job);
  }

  /** Shows the quick look, if there is one, because the job has no picture yet. */
  async #showNothing(job, signal, text = '') {
    const quick = unfinished(job) ? await this.#quickLook(job, signal) : undefined;
    if (signal.aborted) return;
    if (quick) this.viewer.show(noPicture(job), quick);
    this.viewer.showMessage(text || (quick ? '' : whyNoPicture(job)));
  }

  #quickPicture;
  async #quickLook(job, signal) {
    const quick = quickLookOf(job.id) ?? this.#quick;
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
  async #loadResults(job) {
    const {signal} = this.#shown;
    try {
      const report = await getJson(`jobs/${job.id}/report`, signal);
      if (signal.aborted) return;
      this.#workers = report.workers;
      this.report.replaceChildren(reportOf(report), recipeOf(fileOf(job) + '.png'));
      setText(this.now, headline(job, this.#workers));
      const error = await fetchMap('error', job.id, signal);
      if (!signal.aborted) this.viewer.showMap(error);
    } catch (problem) {
      if (!signal.aborted) notify(problem.message, 'error');
    }
  }

  #showHistory(events) {
    this.past.hidden = !events.length;
    this.history.replaceChildren(...events.map(({at, what}) => el('li', {},
      el('time', {datetime: new Date(at * 1000).toISOString()}, moment(at)), el('span', {}, what))));
  }
}
