// The forecast of a job: how long it would take on this farm.

import {radiance, whole} from './format.js';

export const hour = 3600;
export const day = 24 * hour;

const slowest = 3e4;  // samples per second and thread that even heavy scenes reach
const noise = 0.2;  // high variance of a sample; noise / error² samples reach an error

/** Returns whether the job might take more than an hour on `threads` threads. Errs on the side of true, so that
 *  other jobs need no forecast. `numbers`: settings without options. */
export function mayTakeLong(options, numbers, threads) {
  const {spp = numbers.samples_per_pixel, target_error, target_half_width, time_limit, quality, frames} = options;
  if (time_limit <= hour) return false;
  if (frames !== undefined) return true;
  const error = target_error ?? (target_half_width ? target_half_width / 3 : undefined) ?? {draft: 0.05, good: 0.02, print: 0.005}[quality] ?? (spp ? undefined : 0.02);
  const samples = error === undefined ? spp : Math.min(options.spp ?? Infinity, noise / error ** 2);
  const scale = quality === 'print' ? 4 : 1;
  return scale * samples * (options.width ?? numbers.width) * (options.height ?? numbers.height) > hour * slowest * Math.max(1, threads);
}

/** Formats an estimated time with few digits: "3 min". */
export function roughly(seconds) {
  if (seconds < 1) return '1 s';
  for (const [most, size, unit] of [[90, 1, 's'], [90 * 60, 60, 'min'], [2 * day, hour, 'h']]) if (seconds < most) return `${Math.round(seconds / size)} ${unit}`;
  return `${whole(seconds / day)} days`;
}

/** Returns the expected seconds of a forecast with the time in the queue; 0: not known. */
export const secondsOf = plan => (plan?.seconds?.expected ?? 0) + (plan?.queue_seconds ?? 0);

/** Formats a forecast: "about 3 min on 8 threads, after 12 min in the queue; error 0.02". */
export function forecastText({seconds, threads = 0, queue_seconds = 0, thread_seconds, error, frames}) {
  const rmse = error?.rmse;
  const parts = [];
  if (threads > 0 && seconds) {
    parts.push(`about ${roughly(seconds.expected)} on ${whole(threads)} ${threads === 1 ? 'thread' : 'threads'}`);
    if (queue_seconds >= 1) parts.push(`after ${roughly(queue_seconds)} in the queue`);
  } else {
    parts.push(thread_seconds > 0 ? `about ${roughly(thread_seconds)} of one thread` : 'time unknown', 'when workers are connected');
  }
  return parts.join(', ') + (frames > 1 ? `, ${frames} frames` : '') + (typeof rmse === 'number' ? `; error ${radiance(rmse)}` : '');
}
