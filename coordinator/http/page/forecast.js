// The forecast of a job: how long it would take on this farm.

import {radiance, whole} from './format.js';

export const hour = 3600;
export const day = 24 * hour;

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
