// The frames of a series: player, thumbnails, counts by state and times.

import {getJson} from './api.js';
import {button, el, notify, setClass, setText} from './dom.js';
import {duration, percent, unfinished} from './format.js';
import {FrameTimes} from './frame_times.js';
import {requeueAll} from './job_actions.js';
import {mayControl} from './job_rules.js';
import {Player} from './player.js';
import {Thumbnails} from './thumbnails.js';

const thumbnailWidth = 128;
const pageOfFrames = 1000;
const stoppedStates = ['failed', 'cancelled'];
const order = ['done', 'running', 'finishing', 'queued', 'paused', 'failed', 'cancelled'];

/** Returns the state of a frame: "held" if nobody has paused it, but the coordinator holds it back. */
const stateOf = ({state, reason}) => state === 'paused' && !reason?.startsWith('paused by ') ? 'held' : state;

/** Returns a frame's entry with the state of its job map. */
const entryOf = (entry, job) => ({...entry, state: job.state, reason: job.reason, seconds: job.seconds_taken ?? entry.seconds,
  rmse: job.error?.rmse ?? entry.rmse, progress: job.progress, has_picture: job.has_picture ?? job.state === 'done'});

export class Series {
  #farm;
  #job;
  #cells = new Map();  // {entry, element, ...}, by frame number, in their order
  #frameOfJob = new Map();
  #marked;  // button of the frame that the player shows
  #thumbnails = new Thumbnails(thumbnailWidth);

  constructor(farm) {
    this.#farm = farm;
    this.player = new Player(entry => this.#mark(entry));
    this.grid = el('ol', {class: 'frame-grid', 'aria-label': 'Frames'});
    this.more = button('More frames', () => this.#loadMore(), {hidden: true});
    this.scroller = el('div', {class: 'frame-scroll', tabindex: 0, role: 'group', 'aria-label': 'Thumbnails'}, this.grid, this.more);
    this.element = el('div', {class: 'series', hidden: true}, this.player.element, this.scroller);
    this.counts = el('ul', {class: 'counts', 'aria-label': 'Frames by state'});
    this.holes = el('p', {class: 'notice', hidden: true});
    this.requeue = button('', () => this.#requeueFailed(), {hidden: true});
    this.times = new FrameTimes(entry => this.#select(entry));
    this.side = el('div', {class: 'series-side', hidden: true}, this.counts, this.holes, this.requeue, this.times.element);
  }

  clear() {
    this.#job = undefined;
    this.#thumbnails.clear();
    for (const {image} of this.#cells.values()) if (image.src) URL.revokeObjectURL(image.src);
    this.#cells.clear();
    this.#frameOfJob.clear();
    this.grid.replaceChildren();
    this.counts.replaceChildren();
    this.holes.hidden = this.requeue.hidden = this.more.hidden = true;
    this.player.clear();
    this.times.clear();
    this.element.hidden = this.side.hidden = true;
  }

  stop() {
    this.player.stop();
  }

  /** Shows the map of a series. `list`: its first frames; undefined: as before. */
  show(job, list) {
    this.#job = job;
    this.element.hidden = this.side.hidden = false;
    if (job.width) this.grid.style.setProperty('--shape', job.width / job.height);
    if (list) this.#setFrames(list, true);
    else this.#showCounts();
  }

  /** Takes the changes of the frames' jobs. `ids`: numbers of changed jobs. */
  update(ids) {
    let changed = false;
    for (const id of ids) {
      const cell = this.#cells.get(this.#frameOfJob.get(id));
      const job = this.#farm.jobs.get(id);
      if (!cell || !job) continue;
      changed = true;
      this.#fill(cell, entryOf(cell.entry, job));
    }
    if (changed) this.#changed();
  }

  /** `first`: the list begins with the first frame, so it replaces what it covers. */
  #setFrames(list, first) {
    const listed = new Set(list.map(entry => entry.frame));
    const end = list.at(-1)?.frame ?? -1;
    const full = list.length === pageOfFrames;  // others may follow
    if (first) {
      for (const [frame, cell] of this.#cells) {
        if (listed.has(frame) || full && frame > end) continue;
        cell.element.remove();
        this.#cells.delete(frame);
      }
    }
    for (const entry of list) {
      let cell = this.#cells.get(entry.frame);
      if (!cell) {
        cell = this.#makeCell();
        this.#cells.set(entry.frame, cell);
        this.grid.append(cell.element);
      }
      this.#frameOfJob.set(entry.job, entry.frame);
      this.#fill(cell, {...entry, has_picture: entry.has_picture ?? entry.state === 'done'});
    }
    this.#sortCells();
    this.#changed();
    if (full && [...this.#cells.keys()].some(frame => frame > end)) this.#loadAfter(end).catch(() => {});
  }

  /** Restores the order of frames, which changes if a frame is submitted late. */
  #sortCells() {
    const frames = [...this.#cells.keys()];
    if (frames.every((frame, i) => i === 0 || frames[i - 1] < frame)) return;
    this.#cells = new Map([...this.#cells].sort(([a], [b]) => a - b));
    this.grid.replaceChildren(...[...this.#cells.values()].map(cell => cell.element));
  }

  #entries() {
    return [...this.#cells.values()].map(cell => cell.entry);
  }

  /** The frames that can be queued again. */
  #stopped() {
    return this.#entries().filter(entry => stoppedStates.includes(entry.state));
  }

  /** Returns the states of the frames, or undefined as long as some of them are not loaded. */
  get states() {
    return this.#cells.size && this.more.hidden ? new Set(this.#entries().map(stateOf)) : undefined;
  }

  #changed() {
    const entries = this.#entries();
    this.player.setFrames(entries);
    this.times.set(entries);
    this.#showCounts();
  }

  #makeCell() {
    const cell = {image: el('img', {alt: ''}), number: el('span', {class: 'number'}), note: el('span', {}), more: el('span', {class: 'unseen'})};
    cell.button = button('', () => this.#select(cell.entry), {class: 'frame'});
    cell.button.append(cell.image, el('span', {class: 'frame-text'}, el('span', {class: 'unseen'}, 'Frame '), cell.number, cell.note, cell.more));
    cell.element = el('li', {}, cell.button);
    return cell;
  }

  #fill(cell, entry) {
    const before = cell.entry;
    cell.entry = entry;
    setText(cell.number, String(entry.frame));
    const note = entry.state === 'done' && entry.seconds > 0 ? duration(entry.seconds) : entry.state === 'running' ? percent(entry.progress ?? 0) : entry.state;
    setText(cell.note, note);
    setClass(cell.note, 'state ' + entry.state);
    const reason = entry.reason ? ': ' + entry.reason : '';
    setText(cell.more, (note === entry.state ? '' : `, ${entry.state}`) + reason);
    cell.button.title = `Frame ${entry.frame}, ${entry.state}${reason}`;
    const fresh = entry.has_picture && (!before?.has_picture || before.state !== entry.state || before.job !== entry.job);
    if (fresh) this.#thumbnails.load(cell.image, entry.job);
  }

  #select(entry) {
    this.player.stop();
    this.player.show(this.#entries().findIndex(each => each.frame === entry.frame));
  }

  #mark(entry) {
    this.#marked?.setAttribute('aria-pressed', 'false');
    this.#marked = this.#cells.get(entry.frame)?.button;
    this.#marked?.setAttribute('aria-pressed', 'true');
    if (this.#marked) this.#reveal(this.#marked);
  }

  /** Scrolls the thumbnails, and nothing else, so that one of them is visible. */
  #reveal(cell) {
    const [box, view] = [cell.getBoundingClientRect(), this.scroller.getBoundingClientRect()];
    if (box.top < view.top) this.scroller.scrollTop += box.top - view.top - 8;
    else if (box.bottom > view.bottom) this.scroller.scrollTop += box.bottom - view.bottom + 8;
  }

  #showCounts() {
    const entries = this.#entries();
    const numbers = new Map();
    for (const {state} of entries) numbers.set(state, (numbers.get(state) ?? 0) + 1);
    const text = order.filter(state => numbers.has(state)).map(state => `${numbers.get(state)} ${state}`);
    if (text.join() !== [...this.counts.children].map(item => item.textContent).join()) {
      this.counts.replaceChildren(...text.map(each => el('li', {class: 'state ' + each.replace(/^\d+ /, '')}, each)));
    }
    const stopped = stoppedStates.filter(state => numbers.has(state));
    const count = this.#stopped().length;
    // A series that has ended has a button Requeue of its own.
    this.requeue.hidden = !count || !unfinished(this.#job) || !mayControl(this.#job, this.#farm.server);
    setText(this.requeue, `Requeue ${count} ${stopped.join(' or ')} ${count === 1 ? 'frame' : 'frames'}`);
    const missing = this.#job.frames - entries.length;
    // A full page may be followed by others.
    this.more.hidden = missing <= 0 || entries.length === 0 || entries.length % pageOfFrames !== 0;
    this.holes.hidden = missing <= 0 || !this.more.hidden || !entries.length;
    setText(this.holes, `${missing} of ${this.#job.frames} frames ${missing === 1 ? 'is' : 'are'} missing: deleted, or not submitted yet. ` +
      'Repeat the command that submitted the series to submit them.');
  }

  async #loadMore() {
    try {
      await this.#loadAfter([...this.#cells.keys()].at(-1));
    } catch (problem) {
      notify(problem.message, 'error');
    }
  }

  /** Loads the frames after frame `last`. Throws Problem. */
  async #loadAfter(last) {
    const id = this.#job.id;
    const {frame_list: list = []} = await getJson(`jobs/${id}?from_frame=${last + 1}`);
    if (id === this.#job?.id) this.#setFrames(list, false);
  }

  async #requeueFailed() {
    this.requeue.disabled = true;
    const ids = this.#stopped().map(entry => entry.job).slice(0, pageOfFrames);
    const problems = await requeueAll(this.#farm, ids);
    this.requeue.disabled = false;
    if (problems.length) notify(problems[0] + (problems.length > 1 ? ` (and ${problems.length - 1} more)` : ''), 'error');
    else notify(ids.length === 1 ? '1 frame is queued again.' : `${ids.length} frames are queued again.`);
  }

  /** Handles a key of the view. Returns true if it has a meaning here. */
  key(event) {
    const inControl = event.target.closest('button, a, summary, select, input');
    if (event.key === ' ' && !inControl) this.player.toggle();
    else if (event.target.matches('input')) return false;
    else if (event.key === 'ArrowLeft') this.player.step(-1);
    else if (event.key === 'ArrowRight') this.player.step(1);
    else return false;
    return true;
  }
}

/** Finds the neighbours of a frame in its series: {before, after}, job numbers or undefined, and `series`, the map of the
 *  series. Throws Problem. */
export async function neighboursOf(job, signal) {
  let before;
  for (let from = 0;;) {
    const series = await getJson(`jobs/${job.series}?from_frame=${from}`, signal);
    const {frame_list: list = []} = series;
    const at = list.findIndex(entry => entry.frame === job.frame);
    if (at >= 0) {
      const last = at === list.length - 1 && list.length === pageOfFrames;
      const after = last ? (await getJson(`jobs/${job.series}?from_frame=${job.frame + 1}`, signal)).frame_list?.[0] : list[at + 1];
      return {before: list[at - 1]?.job ?? before, after: after?.job, series};
    }
    if (list.length < pageOfFrames) return {series};
    before = list.at(-1).job;
    from = list.at(-1).frame + 1;
  }
}
