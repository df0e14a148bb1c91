// What a user may do with a job, by the coordinator's rules. tests/browser/fake_rules.py states the same rules.

import {unfinished} from './format.js';

const open = ['pause', 'cancel', 'priority'];
const actionsOf = {  // the actions that each state permits
  queued: open, running: open, finishing: ['cancel', 'priority'], paused: ['resume', 'cancel', 'priority'],
  done: ['delete'], failed: ['requeue', 'delete'], cancelled: ['requeue', 'delete']};

/** Returns whether the user may control the job: not before the server has said who the user is. A missing role or user
 *  means that the server decides. */
export const mayControl = (job, server) => Boolean(server) && (server.role !== 'client' || !server.user || server.user === job.user);

/** Returns whether the coordinator itself holds the job back, for example because its disk is full. Nobody can resume it. */
const heldBack = job => job.state === 'paused' && Boolean(job.reason) && !job.reason.startsWith('paused by ');

/** Returns whether all submitted frames of a series have ended, and others are missing. */
export const waitsForFrames = job => job.frames > 0 && job.state === 'queued' && /^\d+ of \d+ frames: /.test(job.waits_for ?? '');

/** Returns whether some frames of a series have failed or were cancelled. */
const hasStoppedFrames = job => /^\d+ of \d+ frames (failed|were cancelled)/.test(job.reason ?? '');

function permitsSeries(job, word, frames) {
  if (word === 'requeue' && hasStoppedFrames(job)) return true;
  if (waitsForFrames(job)) return word === 'delete';
  if (frames && word === 'pause') return ['queued', 'running', 'held'].some(state => frames.has(state));
  if (frames && word === 'resume') return frames.has('paused');
  return actionsOf[job.state]?.includes(word) ?? false;
}

/** Returns whether `word` (pause, resume, cancel, requeue, delete, priority) makes sense for the state of a job.
 *  `frames`: Set of the states of a series' frames, if all are known. `series`: map of a frame's series, if it is known. */
export function permits(job, word, {frames, series} = {}) {
  if (job.frames) return permitsSeries(job, word, frames);
  if (word === 'resume' && heldBack(job)) return false;
  if (word === 'delete' && job.frame !== undefined && (!series || unfinished(series))) return false;
  return actionsOf[job.state]?.includes(word) ?? false;
}
