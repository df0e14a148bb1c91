// A plot of a job's error against time on a logarithmic scale: one point per pass, from the server and from later events.

import {svg} from './dom.js';
import {duration, estimate, radiance, whole} from './format.js';

const [width, height, left, right, top, bottom] = [338, 150, 46, 8, 8, 20];
const mostPoints = 400;
const mostDots = 40;  // more of them would hide the line

/** Returns 1, 2 and 5 times powers of ten from `low` to `high`, at most about four of them. */
function ticks(low, high) {
  const all = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); ++power) {
    for (const step of [1, 2, 5]) {
      const value = step * 10 ** power;
      if (value >= low && value <= high) all.push(value);
    }
  }
  const stride = Math.ceil(all.length / 4);
  return all.filter((_, i) => i % stride === 0);
}

export class Trend {
  element = svg('svg', {class: 'trend', viewBox: `0 0 ${width} ${height}`, role: 'img'});
  #points = [];  // {seconds, samples, rmse} in the order of time
  #target = 0;

  clear() {
    this.#points = [];
    this.#draw();
  }

  /** Shows the passes of a job map. Points that events have added since the last pass stay. */
  setPasses(passes) {
    const known = passes.filter(({seconds, rmse}) => seconds >= 0 && rmse > 0);
    const end = known.at(-1)?.seconds ?? -1;
    this.#points = [...known, ...this.#points.filter(point => point.seconds > end && point.rmse !== known.at(-1)?.rmse)];
    this.#draw();
  }

  /** Adds a point: the error after `seconds` of the job. `target`: the RMSE that the job shall reach, 0: none. */
  add(seconds, samples, rmse, target) {
    const last = this.#points.at(-1);
    const changed = this.#target !== target;
    this.#target = target;
    if (!(rmse > 0) || !(seconds >= 0) || last && (last.rmse === rmse || last.seconds >= seconds)) {
      if (changed) this.#draw();
      return;
    }
    this.#points.push({seconds, samples, rmse});
    if (this.#points.length > mostPoints) this.#points = this.#points.filter((_, i) => i % 2 === 1 || i === 0);
    this.#draw();
  }

  #draw() {
    this.element.replaceChildren();
    this.element.toggleAttribute('hidden', this.#points.length < 2);
    if (this.#points.length < 2) return;
    const target = this.#target;
    const last = this.#points.at(-1);
    const values = [...this.#points.map(point => point.rmse), ...target > 0 ? [target] : []];
    const [least, most] = [Math.min(...values) / 1.25, Math.max(...values) * 1.1];
    const [low, high] = [Math.log(least), Math.log(most)];
    const x = seconds => left + seconds / last.seconds * (width - left - right);
    const y = value => top + (height - top - bottom) * (high - Math.log(value)) / (high - low);
    const label = (value, kind) => svg('text', {x: left - 6, y: y(value) + 4, 'text-anchor': 'end', class: kind}, radiance(value));
    const line = (value, kind) => svg('path', {class: kind, d: `M${left},${y(value)}H${width}`});
    const farFromTarget = value => !(target > 0) || Math.abs(y(value) - y(target)) > 12;
    this.element.setAttribute('aria-label', `Error from ${estimate(this.#points[0].rmse)} to ${estimate(last.rmse)} in ${duration(last.seconds)}` +
      (target > 0 ? `, target ${radiance(target)}` : ''));
    this.element.append(...ticks(least, most).filter(farFromTarget).flatMap(value => [line(value, 'grid'), label(value)]),
      svg('path', {class: 'axis', d: `M${left},${top}V${height - bottom}H${width}`}),
      svg('text', {x: left, y: height - 5}, 'RMSE against time'),
      svg('text', {x: width, y: height - 5, 'text-anchor': 'end'}, duration(last.seconds)));
    if (target > 0) this.element.append(line(target, 'target'), label(target, 'target'));
    this.element.append(svg('path', {class: 'line', d: 'M' + this.#points.map(({seconds, rmse}) => `${x(seconds)},${y(rmse)}`).join('L')}));
    for (const {seconds, samples, rmse} of this.#points.length > mostDots ? [last] : this.#points) {
      const text = `${duration(seconds)}: RMSE ${estimate(rmse)}${samples > 0 ? `, ${whole(samples)} samples per pixel` : ''}`;
      this.element.append(svg('circle', {cx: x(seconds), cy: y(rmse), r: 2.5}, svg('title', {}, text)));
    }
  }
}
