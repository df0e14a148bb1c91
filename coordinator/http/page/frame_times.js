// The time of each frame of a series: a strip of bars, which shows outliers, and a table.

import {button, el, setText, svg} from './dom.js';
import {duration, estimate} from './format.js';

const [width, height, base] = [340, 64, 60];
const outlier = 2;  // times the median
const drawEvery = 2000;  // ms

const columns = [
  {title: 'Frame', value: entry => entry.frame, text: entry => String(entry.frame)},
  {title: 'State', value: entry => entry.state, text: entry => entry.state},
  {title: 'Time', value: entry => entry.seconds ?? -1, text: entry => entry.seconds > 0 ? duration(entry.seconds) : ''},
  {title: 'RMSE', value: entry => entry.rmse ?? -1, text: entry => entry.rmse > 0 ? estimate(entry.rmse) : ''}];

export class FrameTimes {
  #entries = [];
  #median = 0;
  #sort = {column: columns[0], down: false};
  #timer = 0;

  /** `chosen(entry)`: called when the user chooses a frame. */
  constructor(chosen) {
    this.chosen = chosen;
    this.strip = svg('svg', {class: 'strip', viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: 'none', role: 'img'});
    this.strip.addEventListener('click', event => this.#choose(event));
    this.summary = el('p', {class: 'hint'});
    this.heads = columns.map(column => el('th', {scope: 'col'}, button(column.title, () => this.#sortBy(column))));
    this.body = el('tbody', {});
    this.details = el('details', {class: 'times-table', ontoggle: () => this.#showTable()}, el('summary', {}, 'Times per frame'),
      el('table', {}, el('thead', {}, el('tr', {}, ...this.heads)), this.body));
    this.element = el('div', {class: 'frame-times', hidden: true}, this.summary, this.strip, this.details);
  }

  clear() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    this.#entries = [];
    this.details.open = false;
    this.element.hidden = true;
    this.body.replaceChildren();
  }

  /** Shows the times of `entries`: at once, or within two seconds after the last change. */
  set(entries) {
    this.#entries = entries;
    if (this.#timer) return;
    this.#draw();
    this.#timer = setTimeout(() => {
      this.#timer = 0;
      this.#draw();
    }, drawEvery);
  }

  #draw() {
    const timed = this.#entries.filter(entry => entry.seconds > 0);
    this.element.hidden = !timed.length;
    if (!timed.length) return;
    const sorted = timed.map(entry => entry.seconds).sort((a, b) => a - b);
    this.#median = sorted[sorted.length >> 1];
    const most = sorted.at(-1);
    const longest = timed.find(entry => entry.seconds === most);
    const text = `Time per frame: median ${duration(this.#median)}, longest ${duration(most)} (frame ${longest.frame})`;
    setText(this.summary, text);
    this.strip.setAttribute('aria-label', text);
    const each = width / this.#entries.length;
    this.strip.replaceChildren(svg('path', {class: 'axis', d: `M0,${base}H${width}`}), ...this.#entries.flatMap((entry, i) => {
      if (!(entry.seconds > 0)) return [];
      const tall = Math.max(1, base * entry.seconds / most);
      return [svg('rect', {x: i * each, y: base - tall, width: Math.max(0.5, each * 0.8), height: tall, class: this.#kindOf(entry)},
        svg('title', {}, `Frame ${entry.frame}: ${duration(entry.seconds)}, ${entry.state}`))];
    }));
    this.#showTable();
  }

  #kindOf(entry) {
    return entry.state === 'failed' ? 'failed' : entry.seconds > outlier * this.#median ? 'outlier' : entry.state === 'done' ? '' : 'open';
  }

  #choose(event) {
    const box = this.strip.getBoundingClientRect();
    const entry = this.#entries[Math.floor((event.clientX - box.left) / box.width * this.#entries.length)];
    if (entry) this.chosen(entry);
  }

  #sortBy(column) {
    this.#sort = {column, down: this.#sort.column === column && !this.#sort.down};
    this.#showTable();
  }

  #showTable() {
    if (!this.details.open) return;
    const {column, down} = this.#sort;
    for (const [i, head] of this.heads.entries()) {
      if (columns[i] === column) head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      else head.removeAttribute('aria-sort');
    }
    const order = (a, b) => column.value(a) < column.value(b) ? -1 : column.value(a) > column.value(b) ? 1 : a.frame - b.frame;
    const sorted = [...this.#entries].sort((a, b) => down ? order(b, a) : order(a, b));
    this.body.replaceChildren(...sorted.map(entry => el('tr', {class: this.#kindOf(entry)}, ...columns.map(each =>
      el('td', {}, each === columns[0] ? el('a', {href: `#/jobs/${entry.job}`}, each.text(entry)) : each.text(entry))))));
  }
}
