// The actions on a job: its buttons, its downloads and its priority.

import {change, download, getJson} from './api.js';
import {button, confirm, el, notify} from './dom.js';
import {stem, unfinished} from './format.js';
import {hasErrorMap, hasPicture} from './job_facts.js';
import {mayControl, permits} from './job_rules.js';

const words = ['pause', 'resume', 'requeue', 'cancel', 'delete'];
const doneTexts = {pause: 'is paused', resume: 'is resumed', cancel: 'is cancelled', requeue: 'is queued again', delete: 'is deleted'};
const warnings = {
  cancel: 'Its workers stop. The samples are kept, and you can requeue the job.',
  delete: 'The server deletes the job and its picture. This cannot be undone.'};

const capital = word => word[0].toUpperCase() + word.slice(1);
export const fileOf = job => `${stem(job.name || 'job')}-${job.id}`;

/** Creates a button that downloads `path` of a job as `file`. */
function saving(text, job, path, file) {
  return button(text, async event => {
    event.target.disabled = true;
    try {
      await download(`jobs/${job.id}/${path}`, file);
    } catch (problem) {
      notify(problem.message, 'error');
    }
    event.target.disabled = false;
  });
}

export class JobActions {
  #farm;
  #shown = '';
  #downloads = '';
  #job;
  #known = {};  // of the frames or the series of the job

  /** `deleted(job)`: called after this user has deleted the job. */
  constructor(farm, deleted) {
    this.#farm = farm;
    this.deleted = deleted;
    this.element = el('div', {class: 'actions', role: 'group', 'aria-label': 'Job actions'});
    this.priority = el('input', {type: 'number', min: 0, max: 100, required: true, 'aria-label': 'Priority, 0 to 100'});
    this.steer = el('form', {class: 'inline', hidden: true, onsubmit: event => this.#setPriority(event)},
      el('label', {}, 'Priority ', this.priority), el('button', {type: 'submit'}, 'Set'));
    this.save = el('div', {class: 'actions', role: 'group', 'aria-label': 'Download'});
  }

  clear() {
    this.#shown = this.#downloads = '';
    this.#job = undefined;
    this.element.replaceChildren();
    this.save.replaceChildren();
    this.steer.hidden = true;
  }

  /** `known`: what is known of the job's frames or of its series, as for permits(). */
  show(job, known = {}) {
    this.#job = job;
    this.#known = known;
    this.steer.hidden = !this.#offers('priority');
    if (document.activeElement !== this.priority) this.priority.value = job.priority;
    const offered = words.filter(word => this.#offers(word));
    const actions = [job.id, ...offered].join();
    if (actions !== this.#shown) this.#showButtons(offered);
    this.#shown = actions;
    const downloads = [job.id, job.state, hasPicture(job), hasErrorMap(job), job.frames_done > 0].join();
    if (downloads !== this.#downloads) this.#showDownloads(job);
    this.#downloads = downloads;
  }

  #offers(word) {
    const job = this.#job;
    // An unfinished series has a button for its failed frames beside them.
    if (word === 'requeue' && job.frames && unfinished(job)) return false;
    return mayControl(job, this.#farm.server) && permits(job, word, this.#known);
  }

  #showButtons(permitted) {
    const had = this.element.contains(document.activeElement);
    this.element.replaceChildren(...permitted.map(word => button(capital(word), () => this.act(word), {class: warnings[word] ? 'danger' : undefined})));
    if (had) (this.element.querySelector('button:not(.danger)') ?? document.getElementById('job-title')).focus();
  }

  #showDownloads(job) {
    const name = fileOf(job);
    const buttons = job.frames ? [job.frames_done > 0 && saving('All frames (zip)', job, 'frames.zip', name + '.zip')] : [
      hasPicture(job) && saving('PNG', job, 'image.png', name + '.png'),
      hasPicture(job) && saving('EXR', job, 'image.exr', name + '.exr'),
      hasErrorMap(job) && saving('Error map', job, 'error.png', name + '-error.png'),
      job.state === 'done' && hasPicture(job) && saving('Report', job, 'report', name + '.json')];
    this.save.replaceChildren(...buttons.filter(Boolean));
    if (this.save.childElementCount) this.save.prepend(el('span', {}, 'Download'));
  }

  /** Performs an action: pause, resume, cancel, requeue or delete. */
  async act(word) {
    const job = this.#job;
    if (!job || !permits(job, word, this.#known)) return;
    if (warnings[word] && !await confirm(`${capital(word)} job ${job.id}?`, warnings[word], 'Keep job', `${capital(word)} job`)) return;
    try {
      if (word === 'delete') {
        await change('DELETE', `jobs/${job.id}`);
        this.deleted(job);
        this.#farm.removeJob(job.id);
      } else {
        this.#farm.updateJob(await change('POST', `jobs/${job.id}/${word}`));
      }
      notify(`Job ${job.id} ${doneTexts[word]}.`);
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }

  /** Pauses or resumes the job (key p), or says why it cannot. */
  pauseOrResume() {
    const job = this.#job;
    if (!job || !this.#farm.server) return;
    const word = job.state === 'paused' ? 'resume' : 'pause';
    if (!mayControl(job, this.#farm.server)) notify(`Job ${job.id} belongs to ${job.user}. Only ${job.user} and administrators can ${word} it.`);
    else if (!permits(job, word, this.#known)) notify(word === 'resume' ? `Job ${job.id} cannot be resumed now${job.reason ? ': ' + job.reason : ''}.` : `Job ${job.id} is ${job.state}, so it cannot be paused.`);
    else this.act(word);
  }

  async #setPriority(event) {
    event.preventDefault();
    const job = this.#job;
    try {
      this.#farm.updateJob(await change('PUT', `jobs/${job.id}/priority`, {priority: this.priority.valueAsNumber}));
      notify(`Job ${job.id} has priority ${this.priority.value}.`);
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }
}

/** Queues jobs again, with one request or, on an older server, with one each. Returns the problems' texts. */
export async function requeueAll(farm, ids) {
  try {
    const {results} = await change('POST', 'jobs/requeue', {ids});
    for (const {job} of results) if (job) farm.updateJob(job);
    return results.filter(result => result.problem).map(({id, problem}) => `Job ${id}: ${problem.detail}`);
  } catch (problem) {
    if (problem.status !== 404 && problem.status !== 405) return [problem.message];
  }
  const problems = [];
  for (const id of ids) {
    try {
      farm.updateJob(await change('POST', `jobs/${id}/requeue`));
    } catch (problem) {
      problems.push(problem.message);
    }
  }
  return problems;
}

/** Finds the quick look of a job: a job near it whose preview_of names it. Returns its number or undefined. */
export async function findQuickLook(farm, id, signal) {
  for (const job of farm.jobs.values()) if (job.preview_of === id) return job.id;
  try {  // The page submits a quick look just before or after its job.
    const {jobs} = await getJson(`jobs?limit=20&before=${id + 10}`, signal);
    return jobs.find(job => job.preview_of === id)?.id;
  } catch {
    return undefined;
  }
}
