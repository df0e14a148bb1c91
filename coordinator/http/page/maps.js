// Maps of a picture: error, cost and worker of each pixel.

import {request} from './api.js';
import {estimate, small} from './format.js';
import {opaque, toSrgb} from './picture.js';

/** Title, legend and file of each map, and the text for the value of a pixel. */
export const kinds = {
  error: {title: 'Error', legend: 'half-width of the 95 % interval', file: 'error.f32', text: value => value < 0 ? '± unknown' : `± ${estimate(value)}`},
  cost: {title: 'Cost', legend: 'thread-seconds per pixel', file: 'cost.f32', text: value => value > 0 ? small(value, 's') : 'not traced yet'},
  workers: {title: 'Workers', legend: 'traced by', file: 'workers.u32'}};

/** Loads a map: {kind, width, height, values, low, high} with the ends of the scale, or {.., names} of
 *  workers. Throws Problem. */
export async function fetchMap(kind, id, signal) {
  const response = await request('GET', `jobs/${id}/${kinds[kind].file}`, {signal});
  const width = Number(response.headers.get('Parray-Width'));
  const height = Number(response.headers.get('Parray-Height'));
  const bytes = await response.arrayBuffer();
  const values = kind === 'workers' ? new Uint32Array(bytes) : new Float32Array(bytes);
  if (values.length !== width * height) throw new Error(`the map has ${values.length} pixels instead of ${width * height}`);
  if (kind !== 'workers') return {kind, width, height, values, ...scaleOf(values)};
  const names = (await (await request('GET', `jobs/${id}/workers.json`, {signal})).json()).workers;
  return {kind, width, height, values, names};
}

/** Returns the text for the value of a pixel. */
export function textOf(map, at) {
  const value = map.values[at];
  return map.kind === 'workers' ? map.names[value] ?? 'not traced yet' : kinds[map.kind].text(value);
}

function scaleOf(values) {
  const most = values.reduce((largest, value) => Math.max(largest, value), 0);
  if (most === 0) return {low: 0.001, high: 1};
  const high = roundNumber(most, true);
  const stride = Math.ceil(values.length / 1e6);  // sorting all pixels of a large picture would block the page
  const known = values.filter((value, i) => i % stride === 0 && value > 0).sort();
  return {low: roundNumber(Math.min(known[Math.floor(known.length / 100)] ?? most, high / 10), false), high};
}

/** Rounds to the next 1, 2 or 5 times a power of ten. */
function roundNumber(value, upwards) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (upwards ? [1, 2, 5, 10].find(step => step * power >= value * (1 - 1e-6)) :
    [10, 5, 2, 1].find(step => step * power <= value * (1 + 1e-6)));
}

/** Returns the sRGB bytes of a colour of the option --error-map (cli/output/error_map.h). Its lightness in
 *  L*a*b* rises evenly, so that the order is visible without colour vision. */
function errorColour(share) {
  const t = share;
  const s = 1 - t;
  const bezier = (...points) => [s ** 3, 3 * s * s * t, 3 * s * t * t, t ** 3].reduce((sum, weight, i) => sum + weight * points[i], 0);
  const cubed = f => f > 6 / 29 ? f ** 3 : 3 * (6 / 29) ** 2 * (f - 4 / 29);
  const middle = (16 + 74 * t + 16) / 116;
  const x = 0.95047 * cubed(middle + bezier(41, -16, -48, -18) / 500);
  const y = cubed(middle);
  const z = 1.08883 * cubed(middle - bezier(-52, -48, 25, 70) / 200);
  return [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z]
    .map(linear => Math.round(255 * toSrgb(Math.min(1, Math.max(0, linear)))));
}

const ramp = Array.from({length: 256}, (_, i) => errorColour(i / 255));
const rampWords = Uint32Array.from(ramp, ([r, g, b]) => (opaque | b << 16 | g << 8 | r) >>> 0);

/** Paints the colour scale, from low on the left to high on the right. */
export function paintScale(canvas) {
  canvas.width = ramp.length;
  canvas.height = 1;
  const image = new ImageData(ramp.length, 1);
  new Uint32Array(image.data.buffer).set(rampWords);
  canvas.getContext('2d').putImageData(image, 0, 0);
}

/** Eight colours that people with any colour vision can distinguish (Okabe and Ito). */
const palette = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#f0e442', '#999999'];
export const workerColour = number => palette[number % palette.length];
const paletteWords = Uint32Array.from(palette, text => {
  const [r, g, b] = [1, 3, 5].map(at => parseInt(text.slice(at, at + 2), 16));
  return (opaque | b << 16 | g << 8 | r) >>> 0;
});

/** Writes pixels as paintRadiance does: numbers on a logarithmic scale, workers by colour. White: unknown. */
export function paintMap({kind, values, low, high, names}, words, begin, end) {
  const scale = 255 / Math.log(high / low);
  const offset = Math.log(low);
  for (let i = begin; i < end; ++i) {
    const value = values[i];
    const known = kind === 'workers' ? value < names.length : kind === 'cost' ? value > 0 : value >= 0;
    words[i - begin] = !known ? 0xffffffff : kind === 'workers' ? paletteWords[value % palette.length] :
      rampWords[Math.max(0, Math.min(255, Math.round((Math.log(value) - offset) * scale)))];
  }
}
