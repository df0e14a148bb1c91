// A plot of a job's error against time: one point per pass that this page has seen.

import {duration, estimate, radiance} from './format.js';

const [width, height, left, bottom] = [338, 120, 46, 18];

function shape(tag, attributes, text) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  return node;
}

export class Trend {
  element = shape('svg', {class: 'trend', viewBox: `0 0 ${width} ${height}`, role: 'img'});
  #points = [];  // {at, value}, at in seconds

  clear() {
    this.#points = [];
    this.#draw();
  }

  /** Adds a point. `value`: the value that is compared with the target, or the error. `target` 0: no target. */
  add(value, target) {
    if (!(value > 0) || this.#points.at(-1)?.value === value) return;
    this.#points.push({at: performance.now() / 1000, value});
    this.#draw(target);
  }

  #draw(target = 0) {
    this.element.replaceChildren();
    this.element.toggleAttribute('hidden', this.#points.length < 2);
    if (this.#points.length < 2) return;
    const [first, last] = [this.#points[0], this.#points.at(-1)];
    const values = [...this.#points.map(point => point.value), ...target > 0 ? [target] : []];
    const [low, high] = [Math.log(Math.min(...values) / 1.15), Math.log(Math.max(...values) * 1.15)];
    const x = at => left + (at - first.at) / (last.at - first.at) * (width - left - 6);
    const y = value => (height - bottom) * (high - Math.log(value)) / (high - low);
    this.element.setAttribute('aria-label', `Error from ${estimate(first.value)} to ${estimate(last.value)} in ${duration(last.at - first.at)}` +
      (target > 0 ? `, target ${radiance(target)}` : ''));
    const label = (value, text) => shape('text', {x: left - 6, y: y(value) + 4, 'text-anchor': 'end'}, text);
    this.element.append(shape('path', {class: 'axis', d: `M${left},0V${height - bottom}H${width}`}),
      shape('text', {x: width, y: height - 3, 'text-anchor': 'end'}, `${duration(last.at - first.at)} observed`), label(first.value, radiance(Number(first.value.toPrecision(2)))));
    if (target > 0) {
      this.element.append(shape('path', {class: 'target', d: `M${left},${y(target)}H${width}`}), label(target, radiance(target)));
    }
    this.element.append(shape('path', {class: 'line', d: 'M' + this.#points.map(({at, value}) => `${x(at)},${y(value)}`).join('L')}),
      ...this.#points.map(({at, value}) => shape('circle', {cx: x(at), cy: y(value), r: 2.5})));
  }
}
