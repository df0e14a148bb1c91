// Plays the frames of a series and shows one of them.

import {button, el, notify, setText} from './dom.js';
import {unfinished} from './format.js';
import {loadThumbnail} from './thumbnails.js';

const widths = [320, 640, 1024];  // of loaded pictures; one that fills the stage
const ahead = 5;  // frames loaded before they are played
const mostKept = 300;  // loaded pictures

const sleep = time => new Promise(resolve => setTimeout(resolve, time));

export class Player {
  #entries = [];  // the frames, in their order
  #at = -1;  // index of the shown frame; -1: none
  #playing = 0;  // number of the run that plays; 0: stopped
  #runs = 0;
  #kept = new Map();  // promise of a loaded picture's URL, by key
  #showing = 0;

  /** `selected(entry)`: called when another frame is shown. */
  constructor(selected) {
    this.selected = selected;
    this.image = el('img', {alt: ''});
    this.message = el('p', {class: 'message', hidden: true});
    this.screen = el('div', {class: 'screen'}, this.image, this.message);
    this.play = button('▶', () => this.toggle(), {class: 'play', 'aria-label': 'Play', 'aria-keyshortcuts': 'Space'});
    this.slider = el('input', {type: 'range', min: 0, max: 0, value: 0, 'aria-label': 'Frame', oninput: () => {
      this.stop();
      this.show(Number(this.slider.value));
    }});
    this.speed = el('select', {'aria-label': 'Frames per second'}, ...[6, 12, 24].map(rate =>
      el('option', {value: rate, selected: rate === 12}, `${rate} per s`)));
    this.open = el('a', {class: 'open-frame'});
    this.element = el('div', {class: 'player'}, this.screen, el('div', {class: 'player-tools', role: 'group', 'aria-label': 'Playback'},
      button('‹', () => this.step(-1), {'aria-label': 'Previous frame', 'aria-keyshortcuts': 'ArrowLeft'}), this.play,
      button('›', () => this.step(1), {'aria-label': 'Next frame', 'aria-keyshortcuts': 'ArrowRight'}), this.slider, this.speed, this.open));
  }

  clear() {
    this.stop();
    for (const loaded of this.#kept.values()) loaded.then(URL.revokeObjectURL, () => {});
    this.#kept.clear();
    this.#entries = [];
    this.#at = -1;
    ++this.#showing;
    this.image.hidden = true;
    this.image.removeAttribute('src');
    this.#say('');
    setText(this.open, '');
  }

  get current() {
    return this.#entries[this.#at];
  }

  /** Sets the frames. Shows the first one with a picture if none is shown. */
  setFrames(entries) {
    const shown = this.current;
    this.#entries = entries;
    this.slider.max = Math.max(0, entries.length - 1);
    const at = shown ? entries.findIndex(entry => entry.frame === shown.frame) : -1;
    if (at < 0 && entries.length) this.show(Math.max(0, entries.findIndex(entry => entry.has_picture)));
    else this.#at = at;
    const now = entries[at];
    if (now && !this.#playing && (now.state !== shown.state || now.has_picture !== shown.has_picture)) this.show(at);
  }

  /** Shows frame number `at` of the list. Resolves when its picture is visible. */
  async show(at) {
    const entry = this.#entries[at];
    if (!entry) return;
    const mine = ++this.#showing;
    this.#at = at;
    this.slider.value = at;
    this.slider.setAttribute('aria-valuetext', `frame ${entry.frame}, ${entry.state}`);
    setText(this.open, `Open frame ${entry.frame}`);
    this.open.href = `#/jobs/${entry.job}`;
    this.selected(entry);
    if (!entry.has_picture) {
      this.image.hidden = true;
      this.#say(`Frame ${entry.frame} is ${entry.state} and has no picture${unfinished(entry) ? ' yet' : ''}.`);
      return;
    }
    try {
      const url = await this.#load(entry);
      if (mine !== this.#showing) return;
      this.image.src = url;
      this.image.alt = `Frame ${entry.frame}`;
      await this.image.decode().catch(() => {});
      if (mine !== this.#showing) return;
      this.image.hidden = false;
      this.#say('');
    } catch (problem) {
      if (mine !== this.#showing) return;
      this.image.hidden = true;
      this.#say(problem.message);
    }
  }

  /** Shows the next frame (1) or the previous one (-1). */
  step(by) {
    this.stop();
    const at = this.#at + by;
    if (at >= 0 && at < this.#entries.length) this.show(at);
  }

  toEnd(last) {
    this.stop();
    this.show(last ? this.#entries.length - 1 : 0);
  }

  toggle() {
    if (this.#playing) this.stop();
    else this.#run();
  }

  stop() {
    this.#playing = 0;
    setText(this.play, '▶');
    this.play.setAttribute('aria-label', 'Play');
  }

  /** Plays the frames that have a picture, again and again. */
  async #run() {
    if (this.#entries.filter(entry => entry.has_picture).length < 2) {
      notify('The series does not have two pictures yet.');
      return;
    }
    const mine = this.#playing = ++this.#runs;
    setText(this.play, '❚❚');
    this.play.setAttribute('aria-label', 'Pause');
    while (mine === this.#playing) {
      const end = performance.now() + 1000 / Number(this.speed.value);
      const next = this.#nextWithPicture(this.#at);
      let soon = next;
      for (let i = 0; i < ahead; ++i) {
        soon = this.#nextWithPicture(soon);
        this.#load(this.#entries[soon]).catch(() => {});
      }
      await this.show(next);
      await sleep(Math.max(0, end - performance.now()));
    }
  }

  #nextWithPicture(from) {
    for (let i = 1; i <= this.#entries.length; ++i) {
      const at = (from + i) % this.#entries.length;
      if (this.#entries[at].has_picture) return at;
    }
    return from;
  }

  #load(entry) {
    const wanted = this.screen.clientWidth * devicePixelRatio;
    const width = widths.find(each => each >= wanted) ?? widths.at(-1);
    const key = [entry.job, width, entry.state === 'done' ? 'done' : entry.progress].join();
    if (!this.#kept.has(key)) {
      const loaded = loadThumbnail(entry.job, width);
      loaded.catch(() => this.#kept.delete(key));
      this.#kept.set(key, loaded);
      this.#dropOldest();
    }
    return this.#kept.get(key);
  }

  #dropOldest() {
    if (this.#kept.size <= mostKept) return;
    const [key, loaded] = this.#kept.entries().next().value;
    this.#kept.delete(key);
    loaded.then(URL.revokeObjectURL, () => {});
  }

  #say(text) {
    setText(this.message, text);
    this.message.hidden = !text;
  }
}
