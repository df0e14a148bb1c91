// Pictures as numbers, and numbers as colours.

import {request} from './api.js';

const mostExact = 16e6;  // pixels: 192 MB of floats
const mostExactLive = 2e6;  // of a picture that comes anew every few seconds
const mostPixels = 64e6;

const toSrgb = linear => linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
const toLinear = srgb => srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;

const linearOfByte = Float32Array.from({length: 256}, (_, byte) => toLinear(byte / 255));
// By the square root, which spreads the dark end about as sRGB does.
const steps = 4095;
const byteOfRoot = Uint8Array.from({length: steps + 1}, (_, i) => Math.round(255 * toSrgb((i / steps) ** 2)));

/** {width, height, pixels: Float32Array of linear RGB, exact, partial, samples (of all pixels), etag};
 *  `exact` false: from 8 bits. Undefined when nothing has changed since `etag`. Throws Problem. */
export async function fetchPicture(job, etag, signal) {
  const area = job.width * job.height;
  if (area > mostPixels) throw new Error('The picture is too large to show here: download it.');
  const exact = area <= (job.state === 'done' ? mostExact : mostExactLive);
  const path = `jobs/${job.id}/${exact ? 'pixels.f32' : 'image.png'}`;
  const response = await request('GET', path, {headers: etag ? {'If-None-Match': etag} : {}, signal});
  if (response.status === 304) return undefined;
  const fields = response.headers;
  const samples = Number(fields.get('Parray-Samples') ?? 0);
  const rest = {exact, samples, partial: fields.get('Parray-Partial') !== '0', etag: fields.get('ETag')};
  if (!exact) return {...rest, ...await linearOfPng(await response.blob())};
  const width = Number(fields.get('Parray-Width') ?? job.width);
  const height = Number(fields.get('Parray-Height') ?? job.height);
  return {...rest, width, height, pixels: new Float32Array(await response.arrayBuffer())};
}

/** A picture without samples. */
export const noPicture = ({width, height}) => ({width, height, pixels: new Float32Array(3 * width * height), exact: true,
  partial: true, samples: 0, none: true});

async function linearOfPng(blob) {
  const bitmap = await createImageBitmap(blob);
  const {width, height} = bitmap;
  const context = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
  context.drawImage(bitmap, 0, 0);
  const bytes = context.getImageData(0, 0, width, height).data;
  const pixels = new Float32Array(3 * width * height);
  for (let from = 0, to = 0; from < bytes.length; from += 4) {
    pixels[to++] = linearOfByte[bytes[from]];
    pixels[to++] = linearOfByte[bytes[from + 1]];
    pixels[to++] = linearOfByte[bytes[from + 2]];
  }
  return {width, height, pixels};
}

/** {width, height, halfWidths: Float32Array, low, high}: half-widths of pixels and the ends of a scale
 *  for them. Throws Problem. */
export async function fetchErrors(id, signal) {
  const response = await request('GET', `jobs/${id}/error.f32`, {signal});
  const width = Number(response.headers.get('Parray-Width'));
  const height = Number(response.headers.get('Parray-Height'));
  const halfWidths = new Float32Array(await response.arrayBuffer());
  if (halfWidths.length !== width * height) throw new Error(`the error map has ${halfWidths.length} pixels instead of ${width * height}`);
  const most = halfWidths.reduce((largest, value) => Math.max(largest, value), 0);
  if (most === 0) return {width, height, halfWidths, low: 0.001, high: 1};
  const high = roundNumber(most, true);
  const stride = Math.ceil(halfWidths.length / 1e6);  // sorting all of a large picture would hold up the page
  const known = halfWidths.filter((value, i) => i % stride === 0 && value > 0).sort();
  return {width, height, halfWidths, low: roundNumber(Math.min(known[Math.floor(known.length / 100)] ?? most, high / 10), false), high};
}

/** The next 1, 2 or 5 times a power of ten. */
function roundNumber(value, upwards) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (upwards ? [1, 2, 5, 10].find(step => step * power >= value * (1 - 1e-6)) :
    [10, 5, 2, 1].find(step => step * power <= value * (1 + 1e-6)));
}

const opaque = 0xff000000;

/** Writes pixels `begin` to `end` as sRGB, RGBA in a word. Without `whole` pixels of 0, which have not
 *  arrived, are left clear. */
export function paintRadiance({pixels}, words, begin, end, gain, whole) {
  const scale = steps * Math.sqrt(gain);
  for (let i = begin, at = 3 * begin; i < end; ++i, at += 3) {
    const r = pixels[at];
    const g = pixels[at + 1];
    const b = pixels[at + 2];
    words[i - begin] = !whole && r === 0 && g === 0 && b === 0 ? 0 :
      opaque | byteOfRoot[Math.min(steps, scale * Math.sqrt(b)) | 0] << 16 |
      byteOfRoot[Math.min(steps, scale * Math.sqrt(g)) | 0] << 8 | byteOfRoot[Math.min(steps, scale * Math.sqrt(r)) | 0];
  }
}

/** The colours of parray's --error-map (cli/output/error_map.h): L*a*b* whose lightness rises evenly, so
 *  that the order is seen without telling colours apart; sRGB bytes. */
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

/** The colour scale, left to right low to high. */
export function paintScale(canvas) {
  canvas.width = ramp.length;
  canvas.height = 1;
  const image = new ImageData(ramp.length, 1);
  new Uint32Array(image.data.buffer).set(rampWords);
  canvas.getContext('2d').putImageData(image, 0, 0);
}

/** As paintRadiance, of half-widths on a logarithmic scale; white is unknown. */
export function paintErrors({halfWidths, low, high}, words, begin, end) {
  const scale = 255 / Math.log(high / low);
  const offset = Math.log(low);
  for (let i = begin; i < end; ++i) {
    const value = halfWidths[i];
    words[i - begin] = value < 0 ? 0xffffffff :
      rampWords[Math.max(0, Math.min(255, Math.round((Math.log(value) - offset) * scale)))];
  }
}
