// A chart of the last hour: lines over time as SVG, with a summary for screen readers and a table.

import {el, setText, svg} from './dom.js';
import {ago} from './parts.js';

const hour = 3600;  // seconds
const spans = [12 * 60, 20 * 60, 40 * 60, hour];  // lengths of the time axis in seconds; a quarter is a round number
const height = 132;  // px
const top = 16;
const bottom = 18;
const rowsOfTable = 12;

/** Returns a round number that is at least `value`, and whose half is round, too. */
function roundUp(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 1.2, 1.6, 2, 3, 4, 5, 6, 8, 10].find(factor => factor * power >= value * 0.999999) * power;
}

const known = value => typeof value === 'number';
const mean = values => values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : undefined;

export class TimeChart {
  #series;
  #format;
  #title;
  #data = {interval: 10, end: 0, lines: []};
  #width = 0;
  #least;
  #span = hour;

  /** `series`: [{name, kind}]; `kind` area or ceiling is the look. `format(value)` returns a text. `least`: smallest
   *  value at the top. */
  constructor({title, series, format, least = 0}) {
    this.#least = least;
    this.#series = series;
    this.#format = format;
    this.#title = title;
    this.readout = el('span', {class: 'read'});
    this.plot = svg('svg', {role: 'img', height, class: 'time-chart'});
    this.body = el('tbody');
    this.table = el('details', {ontoggle: () => this.#fillTable()}, el('summary', {}, 'Table'),
      el('table', {}, el('caption', {class: 'unseen'}, `${title}, means of five minutes`),
        el('thead', {}, el('tr', {}, el('th', {scope: 'col'}, 'Until'), ...series.map(({name}) => el('th', {scope: 'col'}, name)))), this.body));
    this.element = el('figure', {class: 'chart'}, el('figcaption', {}, el('span', {class: 'title'}, title), this.readout), this.plot, this.table);
    this.plot.addEventListener('pointermove', event => this.#point(event.offsetX));
    this.plot.addEventListener('pointerleave', () => this.#point());
    new ResizeObserver(([entry]) => {
      this.#width = Math.floor(entry.contentRect.width);
      this.#draw();
    }).observe(this.element);
  }

  /** Shows `lines`, an array of values (null: unknown) for each series. Values are `interval` seconds apart,
   *  oldest first; the last one is of `end` (seconds since 1970). */
  set({interval, end, lines}) {
    this.#data = {interval, end, lines};
    const length = (lines[0]?.length ?? 0) * interval;
    this.#span = spans.find(span => length <= span) ?? hour;
    this.#draw();
    this.#fillTable();
  }

  #x(i, count) {
    return this.#width - (count - 1 - i) * this.#data.interval / this.#span * this.#width;
  }

  #draw() {
    if (this.#width < 40) return;
    const {lines} = this.#data;
    const values = lines.flat().filter(known);
    const most = roundUp(values.reduce((a, b) => Math.max(a, b), this.#least));
    const y = value => height - bottom - value / most * (height - top - bottom);
    this.plot.setAttribute('width', this.#width);
    this.plot.setAttribute('viewBox', `0 0 ${this.#width} ${height}`);
    this.plot.setAttribute('aria-label', this.#summary());
    this.cross = svg('line', {class: 'cross', y1: top, y2: height - bottom, x1: -9, x2: -9});
    this.plot.replaceChildren(...this.#grid(y, most), ...lines.flatMap((line, i) => this.#line(line, this.#series[i].kind, y)),
      ...this.#labels(y, most), ...values.length ? [] : [svg('text', {x: this.#width / 2, y: height / 2, 'text-anchor': 'middle'}, 'no data yet')], this.cross);
    this.#point();
  }

  #grid(y, most) {
    return [0, most / 2, most].map(value => svg('line', {class: 'grid', x1: 0, x2: this.#width, y1: y(value), y2: y(value)}));
  }

  #labels(y, most) {
    const marks = [most / 2, most].map(value => svg('text', {x: 2, y: y(value) - 3}, this.#format(value)));
    const times = [4, 3, 2, 1, 0].map(quarters => quarters * this.#span / 240).map((minutes, i) => svg('text', {x: this.#width * i / 4, y: height - 5,
      'text-anchor': i === 0 ? 'start' : i === 4 ? 'end' : 'middle'}, minutes ? `${minutes} min${i || this.#width < 340 ? '' : ' ago'}` : 'now'));
    return [...marks, ...times];
  }

  #line(line, kind, y) {
    const runs = [];
    line.forEach((value, i) => {
      const x = this.#x(i, line.length);
      if (!known(value) || x < 0) runs.push([]);
      else (runs.at(-1) ?? runs[runs.push([]) - 1]).push(`${x.toFixed(1)} ${y(value).toFixed(1)}`);
    });
    return runs.filter(run => run.length).flatMap(run => [
      ...kind === 'area' ? [svg('path', {class: 'fill', d: `M${run[0].split(' ')[0]} ${y(0)}L${run.join('L')}L${run.at(-1).split(' ')[0]} ${y(0)}Z`})] : [],
      svg('path', {class: `stroke ${kind}`, d: `M${run.join('L')}${run.length === 1 ? 'h1' : ''}`})]);
  }

  /** Returns the values `back` steps before the end as a text. */
  #textAt(back) {
    return this.#data.lines.map((line, i) => {
      const value = line.at(-1 - back);
      return known(value) ? (i ? `${this.#series[i].name} ` : '') + this.#format(value) : undefined;
    }).filter(Boolean).join(' ') || 'unknown';
  }

  #point(x) {
    const {interval, end, lines} = this.#data;
    const back = x === undefined ? 0 : Math.round((this.#width - x) / this.#width * this.#span / interval);
    const length = lines[0]?.length ?? 0;
    const shown = x !== undefined && back < length;
    if (this.cross) for (const name of ['x1', 'x2']) this.cross.setAttribute(name, shown ? this.#x(length - 1 - back, length) : -9);
    setText(this.readout, length ? (shown ? `${ago(end - back * interval, end)}: ${this.#textAt(back)}` : this.#textAt(0)) : '');
  }

  #summary() {
    const line = (this.#data.lines[0] ?? []).filter(known);
    if (!line.length) return `${this.#title}, last hour: no data yet`;
    const [low, high] = [line.reduce((a, b) => Math.min(a, b)), line.reduce((a, b) => Math.max(a, b))];
    return `${this.#title}, last hour: now ${this.#textAt(0)}, lowest ${this.#format(low)}, highest ${this.#format(high)}, mean ${this.#format(mean(line))}`;
  }

  #fillTable() {
    if (!this.table.open) return;
    const {interval, end, lines} = this.#data;
    const each = hour / rowsOfTable / interval;
    const rows = [];
    for (let row = 0; row < rowsOfTable; ++row) {
      const until = new Date((end - row * each * interval) * 1000);
      const means = lines.map(line => mean(line.slice(Math.max(0, line.length - (row + 1) * each), Math.max(0, line.length - row * each)).filter(known)));
      if (means.every(value => value === undefined)) break;
      rows.push(el('tr', {}, el('th', {scope: 'row'}, until.toLocaleTimeString(undefined, {hour: '2-digit', minute: '2-digit', hourCycle: 'h23'})),
        ...means.map(value => el('td', {}, value === undefined ? '' : this.#format(value)))));
    }
    this.body.replaceChildren(...rows);
  }
}
