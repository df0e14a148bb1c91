// The rows of the list of jobs: one line for each job.

import {button, el, setAttribute, setClass, setText} from './dom.js';
import {duration, errorOfGoal, estimate, goal, goals, moment, nth, percent, radiance, rate, sampleLimit, samplesOf, unfinished, whole} from './format.js';
import {ago} from './parts.js';

// {name, sorts: [[order of the server, label]]}. Without `sorts`, `title` is the label.
const columns = [
  {name: 'choose'}, {name: 'look', title: el('span', {class: 'unseen'}, 'Picture')}, {name: 'id', sorts: [['id', 'Job']]}, {name: 'name', sorts: [['name', 'Scene']]},
  {name: 'state', sorts: [['state', 'State']]}, {name: 'progress', sorts: [['progress', 'Progress'], ['taken', 'Took']]}, {name: 'left', title: 'ETA'},
  {name: 'error', title: 'Error'}, {name: 'speed', title: 'Speed'}, {name: 'size', title: 'Picture'}, {name: 'submitted', sorts: [['submitted', 'Submitted']]},
  {name: 'ended', sorts: [['finished', 'Ended']]}, {name: 'user', sorts: [['user', 'User']]}, {name: 'priority', sorts: [['priority', 'Prio.', 'Priority']]}];

/** Returns the columns with their heads. `all`: the element of the head of the first column. `sort(order)`: called for a click. */
export const headsOf = (all, sort) => columns.map(({name, title, sorts = []}) => ({name, title: name === 'choose' ? all : title ??
  el('span', {class: 'orders'}, ...sorts.map(([order, text, label]) => button(text, () => sort(order), {'data-order': order, title: label, 'aria-label': label && `${text} ${label}`})))}));

/** Marks the column that sorts the list. */
export function showOrder(head, {sort, order}) {
  for (const cell of head.children) {
    const buttons = [...cell.querySelectorAll('[data-order]')];
    const mine = buttons.some(({dataset}) => dataset.order === sort);
    setAttribute(cell, 'aria-sort', buttons.length ? mine ? order === 'asc' ? 'ascending' : 'descending' : 'none' : undefined);
    for (const one of buttons) setClass(one, one.dataset.order === sort ? order : '');
  }
}

/** Creates the cells of a row. `chosen(event, job)`: called for a click on its checkbox. */
export function makeRow(row, chosen) {
  const parts = {row};
  for (const {name} of columns) {
    parts[name] = el('div', {class: name, role: 'cell'});
    row.append(parts[name]);
  }
  parts.check = el('input', {type: 'checkbox', onclick: event => chosen(event, parts.job)});
  parts.choose.append(el('label', {}, parts.check));
  parts.image = el('img', {alt: '', hidden: true, decoding: 'async'});
  parts.look.append(parts.image);
  parts.link = el('a', {});
  parts.quick = el('a', {class: 'quick', hidden: true}, 'quick look');
  parts.name.append(parts.link, parts.quick);
  parts.bar = el('span', {class: 'bar', 'aria-hidden': 'true'});
  parts.done = el('span', {class: 'share'});
  parts.note = el('span', {class: 'note'});
  parts.progress.append(parts.bar, parts.done, parts.note);
  parts.value = el('span', {});
  parts.target = el('span', {class: 'target'});
  parts.error.append(parts.value, parts.target);
  parts.when = el('time', {});
  parts.end = el('time', {});
  parts.submitted.append(parts.when);
  parts.ended.append(parts.end);
  return parts;
}

const known = value => value !== undefined && value !== null;
const tookOf = job => known(job.seconds_taken) && job.seconds_taken >= 0 ? duration(job.seconds_taken) : '';
const shareOf = job => job.frames ? `${whole(job.frames_done ?? 0)} / ${whole(job.frames)}` : percent(job.progress);
const waits = job => unfinished(job) && job.state !== 'paused' && Boolean(job.waits_for);

/** Returns the shown state: a job that needs a worker and has begun is "waiting". */
const stateOf = job => job.state === 'running' && waits(job) ? 'waiting' : job.state;

/** Formats an estimate with one number: "5 min". */
function about(seconds) {
  if (seconds < 59.5) return `${Math.max(1, Math.round(seconds))} s`;
  if (seconds < 3570) return `${Math.round(seconds / 60)} min`;
  return seconds < 48 * 3600 ? `${Math.round(seconds / 3600)} h` : `${Math.round(seconds / 86400)} days`;
}

const stateText = job => job.state === 'queued' && known(job.queue_place) ? `queued, ${nth(job.queue_place)}` : stateOf(job);

function etaOf(job) {
  if (!unfinished(job)) return '';
  if (job.state === 'queued') return known(job.starts_in) && job.starts_in >= 0 ? `in ${about(job.starts_in)}` : '';
  return known(job.seconds_left) ? duration(job.seconds_left) : '';
}

/** The text beside or instead of the bar: why the job failed, what it waits for, how long it took. */
function noteOf(job) {
  if (job.state === 'failed') return job.reason || `failed at ${shareOf(job)}`;
  if (job.state === 'cancelled') return `at ${shareOf(job)}${tookOf(job) ? ', ' + tookOf(job) : ''}`;
  if (job.state === 'done') return tookOf(job);
  if (!waits(job)) return '';
  return known(job.waits_for_job) ? `after job ${job.waits_for_job}` : `waits for ${job.waits_for.replace(/ \(.*\)$/, '')}`;
}

function showTime(node, at) {
  setText(node, known(at) ? ago(at) : '');
  setAttribute(node, 'datetime', known(at) ? new Date(at * 1000).toISOString() : undefined);
  setAttribute(node, 'title', known(at) ? moment(at) : undefined);
}

function showProgress(parts, job) {
  const note = noteOf(job);
  const bare = !unfinished(job) || job.state === 'queued' && !(job.progress > 0);
  parts.bar.hidden = bare || waits(job);
  parts.done.hidden = bare;
  setText(parts.done, bare ? '' : shareOf(job));
  parts.bar.style.setProperty('--share', job.progress);
  setText(parts.note, job.state === 'done' && job.frames ? `${shareOf(job)} frames${note ? ', ' + note : ''}` : note);
  const hint = [job.frames && `${shareOf(job)} frames`, waits(job) ? `waits for ${job.waits_for}` : note].filter(Boolean).join(', ');
  setAttribute(parts.progress, 'title', hint || undefined);
}

function showError(parts, job) {
  const to = goal(job);
  const [value, target] = to ? [known(to.now) ? estimate(to.now) : '', `target ${radiance(to.asked)}`] : [errorOfGoal(job), ''];
  setText(parts.value, value);
  setText(parts.target, target);
  setClass(parts.error, to && to.now > 0 && to.now <= to.asked ? 'error reached' : 'error');
  setAttribute(parts.error, 'title', goals(job).map(({kind, now, asked}) => `${kind} ${known(now) ? estimate(now) : 'unknown'}, target ${radiance(asked)}`).join('; ') || undefined);
}

function showSize(node, job) {
  const spp = samplesOf(job);
  setText(node, job.width ? `${job.width} × ${job.height}${spp ? `, ${spp} spp` : ''}` : '');
  const limit = sampleLimit(job);
  setAttribute(node, 'title', job.width ? `${job.width} × ${job.height} pixels, ${[known(job.samples_taken) && `${samplesOf({...job, samples_per_pixel: null})} samples per pixel so far`,
    limit === null ? 'no limit' : limit > 0 && `limit ${whole(limit)}`].filter(Boolean).join(', ')}` : undefined);
}

/** Shows a job. `quick`: its quick look, or undefined. */
export function fillRow(parts, job, {chosen, quick}) {
  parts.job = job;
  const state = stateOf(job);
  const eta = etaOf(job);
  setAttribute(parts.row, 'data-state', job.state);
  parts.row.classList.toggle('waits', waits(job) && !eta);
  parts.row.classList.toggle('chosen', chosen);
  parts.check.checked = chosen;
  setAttribute(parts.check, 'aria-label', `Choose job ${job.id}`);
  setText(parts.id, String(job.id));
  setText(parts.link, job.name || 'untitled');
  setAttribute(parts.link, 'href', `#/jobs/${job.id}`);
  setAttribute(parts.link, 'title', job.name || undefined);
  parts.quick.hidden = !quick;
  if (quick) {
    setText(parts.quick, unfinished(quick) ? 'quick look' : quick.state === 'done' ? 'quick look ✓' : `quick look ${quick.state}`);
    setAttribute(parts.quick, 'href', `#/jobs/${quick.id}`);
  }
  setText(parts.state, stateText(job));
  setClass(parts.state, 'state ' + state);
  showProgress(parts, job);
  setText(parts.left, eta);
  setClass(parts.left, job.warning ? 'left warned' : 'left');
  setAttribute(parts.left, 'title', job.warning || (job.state === 'queued' && eta ? 'estimated time until it begins' : undefined));
  showError(parts, job);
  setText(parts.speed, job.state === 'running' ? rate(job.samples_per_second) : '');
  showSize(parts.size, job);
  showTime(parts.when, job.submitted);
  showTime(parts.end, job.finished);
  setText(parts.user, job.user);
  setAttribute(parts.user, 'title', job.user || undefined);
  setText(parts.priority, String(job.priority));
}
