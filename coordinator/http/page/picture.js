// Loads pictures as numbers, and converts numbers to colours.

import {request} from './api.js';

const mostExact = 16e6;  // pixels; 192 MB of floats
const mostExactLive = 2e6;  // pixels of a picture that is updated every few seconds
const mostPixels = 64e6;

export const toSrgb = linear => linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
const toLinear = srgb => srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;

const linearOfByte = Float32Array.from({length: 256}, (_, byte) => toLinear(byte / 255));
// Indexed by the square root, which resolves dark values about as well as sRGB does.
const steps = 4095;
const byteOfRoot = Uint8Array.from({length: steps + 1}, (_, i) => Math.round(255 * toSrgb((i / steps) ** 2)));

/** Loads a picture: {width, height, pixels: Float32Array of linear RGB, exact, partial, samples (of all
 *  pixels), etag}. `exact` false: from an 8-bit picture. Returns undefined if nothing has changed since
 *  `etag`. Throws Problem. */
export async function fetchPicture(job, etag, signal) {
  const area = job.width * job.height;
  if (area > mostPixels) throw new Error('The picture is too large for this page. Download it instead.');
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

/** Returns a picture without samples. */
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

export const opaque = 0xff000000;

/** Writes pixels `begin` to `end` as sRGB, one RGBA word per pixel. Without `whole`, pixels of 0 have no
 *  sample yet and stay transparent. */
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
