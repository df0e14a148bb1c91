// The view of all jobs, newest first.

import {el, setClass, setText} from './dom.js';
import {duration, errorOfGoal, goal, percent, rate, unfinished, whole} from './format.js';
import {VirtualTable} from './list.js';

export const filters = new Map([
  ['all', []], ['active', ['queued', 'running', 'paused', 'finishing']], ['running', ['running', 'finishing']],
  ['queued', ['queued']], ['paused', ['paused']], ['done', ['done']], ['failed', ['failed']],
  ['cancelled', ['cancelled']]]);

const columns = [
  {name: 'id', title: 'Job'}, {name: 'name', title: 'Scene'}, {name: 'state', title: 'State'},
  {name: 'progress', title: 'Progress'}, {name: 'left', title: 'ETA'}, {name: 'error', title: 'Error'},
  {name: 'speed', title: 'Speed'}, {name: 'size', title: 'Picture'}, {name: 'user', title: 'User'},
  {name: 'priority', title: 'Priority'}];

function make(row) {
  const parts = {};
  for (const {name} of columns) {
    parts[name] = el('div', {class: name, role: 'cell'});
    row.append(parts[name]);
  }
  parts.link = el('a', {});
  parts.name.append(parts.link);
  parts.bar = el('span', {class: 'bar', 'aria-hidden': 'true'});
  parts.done = el('span', {class: 'share'});
  parts.progress.append(parts.bar, parts.done);
  return parts;
}

const progressOf = job => job.frames ? `${job.frames_done ?? 0} of ${job.frames} frames` : percent(job.progress);

function fill(parts, job) {
  setText(parts.id, String(job.id));
  setText(parts.link, job.name || 'untitled');
  parts.link.setAttribute('href', `#/jobs/${job.id}`);
  setText(parts.state, job.state);
  setClass(parts.state, 'state ' + job.state);
  parts.bar.style.setProperty('--share', job.state === 'done' ? 1 : job.progress);
  setText(parts.done, job.state === 'done' ? '' : progressOf(job));
  setText(parts.left, unfinished(job) ? duration(job.seconds_left) || job.waits_for : '');
  const to = goal(job);
  setText(parts.error, errorOfGoal(job));
  setClass(parts.error, to && to.now > 0 && to.now <= to.asked ? 'error reached' : 'error');
  setText(parts.speed, job.state === 'running' ? rate(job.samples_per_second) : '');
  setText(parts.size, job.width ? `${job.width} × ${job.height}, ${whole(job.samples_per_pixel)}` : '');
  setText(parts.user, job.user);
  setText(parts.priority, String(job.priority));
}

export class JobsView {
  title = 'Jobs';
  #farm;
  #filter = 'all';
  #loadedTo = Infinity;  // jobs from this number on are loaded; -Infinity: all
  #loading = false;
  #problem = '';

  constructor(farm) {
    this.#farm = farm;
    this.table = new VirtualTable({label: 'Jobs', kind: 'jobs', columns, make, fill, nearEnd: () => this.#load()});
    this.choice = el('fieldset', {class: 'choice'}, el('legend', {class: 'unseen'}, 'Filter by state'),
      ...[...filters.keys()].map(name => el('label', {},
        el('input', {type: 'radio', name: 'filter', value: name, checked: name === this.#filter,
          onchange: () => this.#choose(name)}), el('span', {}, name))));
    this.count = el('p', {class: 'count', role: 'status'});
    this.empty = el('div', {class: 'empty', hidden: true});
    this.element = el('section', {class: 'view list', 'aria-labelledby': 'jobs-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'jobs-title', tabindex: -1}, 'Jobs'), this.choice, this.count,
        el('a', {class: 'button primary', href: '#/submit'}, 'Submit a scene')),
      this.table.element, this.empty);
  }

  show() {
    this.#rebuild();
  }

  update(changes) {
    if (changes.generation) {
      this.#loadedTo = Infinity;
      this.#load();
    }
    if (changes.shape || changes.generation) this.#rebuild();
    else if (changes.jobs.size) this.table.draw(true);
  }

  #choose(name) {
    this.#filter = name;
    this.#loadedTo = Infinity;
    this.table.scroller.scrollTop = 0;
    this.#load();
    this.#rebuild();
  }

  async #load() {
    if (this.#loading || this.#loadedTo === -Infinity || !this.#farm.generation) return;
    this.#loading = true;
    const filter = this.#filter;
    const generation = this.#farm.generation;
    try {
      const next = await this.#farm.loadJobs(filters.get(filter), this.#loadedTo === Infinity ? undefined : this.#loadedTo);
      if (filter === this.#filter && generation === this.#farm.generation) this.#loadedTo = next ?? -Infinity;
      this.#problem = '';
    } catch (problem) {
      this.#problem = problem.message;
      this.#loadedTo = -Infinity;  // no further attempt until the next connection
    }
    this.#loading = false;
    if (filter !== this.#filter || generation !== this.#farm.generation) this.#load();
    else this.#rebuild();
  }

  #rebuild() {
    const states = filters.get(this.#filter);
    const jobs = [];
    for (const job of this.#farm.jobs.values()) {
      if (job.id >= this.#loadedTo && job.frame === undefined && (!states.length || states.includes(job.state))) {
        jobs.push(job);
      }
    }
    jobs.sort((a, b) => b.id - a.id);
    this.table.set(jobs);
    const more = this.#loadedTo !== -Infinity;
    setText(this.count, jobs.length || !more ? `${jobs.length}${more ? '+' : ''} ${jobs.length === 1 ? 'job' : 'jobs'}` : '');
    this.#showEmpty(jobs.length === 0 && !more);
  }

  #showEmpty(empty) {
    this.empty.hidden = !empty;
    this.table.element.hidden = empty;
    if (!empty) return;
    const nothing = this.#filter === 'all' ? 'No jobs yet.' : `No jobs are ${this.#filter}.`;
    this.empty.replaceChildren(el('p', {}, this.#problem || nothing));
    if (this.#filter !== 'all' || this.#problem) return;
    this.empty.append(el('p', {}, 'Drop a scene or a particle file anywhere on this page, or run'),
      el('pre', {}, 'parray submit SCENE'));
  }
}
