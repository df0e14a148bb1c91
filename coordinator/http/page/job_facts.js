// Texts about one job: what it does, what it waits for, and its facts.

import {el} from './dom.js';
import {count, counted, duration, estimate, goals, percent, radiance, sampleLimit, samplesOf, unfinished, whole} from './format.js';
import {mayControl, permits} from './job_rules.js';
import {age, jobLink} from './parts.js';

/** Formats an estimate: "about 4 min". */
const about = seconds => seconds < 60 ? `about ${Math.max(1, Math.round(seconds))} s` : 'about ' + duration(seconds).replace(/\s\d\d\ss$/, '');

const known = value => value !== null && value !== undefined;

/** Returns whether the pictures of a job can be fetched now. */
export const hasPicture = job => !job.frames && (job.has_picture ?? job.state !== 'queued');

/** Returns whether error.f32 and error.png can be fetched now. Older servers have them for done jobs only. */
export const hasErrorMap = job => job.state === 'done' ? hasPicture(job) : job.has_picture === true && known(job.error?.rmse);

/** Returns the headline. `workers`: the number of workers that traced a done job, or undefined. */
export function headline(job, workers) {
  const took = job.seconds_taken >= 0 && known(job.seconds_taken) ? duration(job.seconds_taken) : '';
  const done = job.frames ? `${job.frames_done ?? 0} of ${job.frames} frames` : percent(job.progress);
  if (job.state === 'done') {
    const by = workers > 0 ? ` on ${counted(workers, 'worker')}` : '';
    return took ? `Took ${took}${by}` : by ? `Rendered${by}` : 'Done';
  }
  if (job.state === 'failed' || job.state === 'cancelled') return `Stopped at ${done}${took ? ` after ${took}` : ''}`;
  if (job.state === 'finishing') return 'Writing the picture';
  if (job.state === 'paused') return `Paused at ${done}`;
  return job.state === 'running' && job.seconds_left >= 0 ? `${done}, ${duration(job.seconds_left)} left` : done;
}

/** Returns the nodes of "Waits for job 7 of priority 50, place 3 in the queue, begins in about 4 min", empty without a wait. */
export function waiting(job) {
  if (!unfinished(job) || job.state === 'paused') return [];
  const nodes = [];
  if (job.waits_for) {
    const link = known(job.waits_for_job) ? jobLink(job.waits_for_job) : undefined;
    const [before, after] = link ? splitAt(job.waits_for, `job ${job.waits_for_job}`) : [job.waits_for];
    nodes.push('Waits for ' + before);
    if (link) nodes.push(after === undefined ? ', behind ' : '', link, after ?? '');
  }
  const rest = [];
  if (known(job.queue_place)) rest.push(job.queue_place === 1 ? 'next in the queue' : `place ${job.queue_place} in the queue`);
  if (known(job.starts_in) && job.starts_in >= 0) rest.push(`begins in ${about(job.starts_in)}`);
  if (rest.length) nodes.push((nodes.length ? ', ' : '') + rest.join(', '));
  return nodes;
}

/** Splits a text before and after a word that no digit follows. Without the word: [text]. */
function splitAt(text, word) {
  for (let at = text.indexOf(word); at >= 0; at = text.indexOf(word, at + 1)) {
    const end = at + word.length;
    if (!/\d/.test(text[end] ?? '')) return [text.slice(0, at), text.slice(end)];
  }
  return [text];
}

/** Returns the text of the samples. `seen`: mean samples per pixel of the shown picture, or undefined. */
function samples(job, seen) {
  const limit = sampleLimit(job);
  const taken = job.samples_taken ?? seen;
  const takenText = taken > 0 ? samplesOf({samples_taken: taken, samples_per_pixel: null}) : '';
  if (job.state === 'done') return takenText || limit ? `${takenText || whole(limit)} per pixel` : '';
  if (limit === null) return takenText && `${takenText} per pixel so far`;
  return `${takenText && takenText + ' of '}${whole(limit)} per pixel`;
}

function errorText(job) {
  const {rmse, low, high} = job.error ?? {};
  if (known(rmse)) return known(low) && known(high) ? `${estimate(rmse)} (${estimate(low)} to ${estimate(high)})` : estimate(rmse);
  const part = job.error_so_far;
  if (part) return `${estimate(part.rmse)} (${estimate(part.low)} to ${estimate(part.high)}) in the ${percent(part.share)} that are rendered`;
  if (job.frames || !(job.progress > 0)) return '';
  return job.state === 'done' && !(job.samples_taken >= 2) ? 'unknown: needs 2 samples per pixel' : unfinished(job) ? 'not known yet' : 'unknown';
}

/** Returns the row of a target: "0.0098 (target 0.01, reached)". */
function targetRow({kind, now, asked}) {
  const reached = known(now) && now <= asked;
  return [kind === 'RMSE' ? 'RMSE target' : 'Half-width target', !known(now) ? radiance(asked) :
    el('span', {class: reached ? 'reached' : ''}, `${estimate(now)} (target ${radiance(asked)}${reached ? ', reached' : ''})`)];
}

const endings = {samples: 'all samples were traced', target_error: 'the RMSE reached its target',
  target_half_width: 'the half-width reached its target', time_limit: 'the time limit'};

/** Returns [[term, value]] for facts(). `seen`: as in samples. `server`: its map, which says who the user is. */
export function factsOf(job, seen, server) {
  const {error = {}} = job;
  const when = at => at > 0 ? age(at) : '';
  const halfWidth = known(error.half_width_p50) ? `median ${estimate(error.half_width_p50)}, 99\u00a0% within ${estimate(error.half_width_p99)}` : '';
  return [
    ['Picture', job.width ? `${job.width} × ${job.height} pixels` : ''],
    ['Denoising', !job.denoise ? '' : job.state === 'done' ? 'denoised' : 'denoised when written'],
    ['Labels', !job.drawn ? '' : job.state === 'done' ? 'drawn in the PNG' : 'drawn when the PNG is written'],
    ['Samples', samples(job, seen)],
    ['Sampler', job.sampler],
    ['Speed', job.state === 'running' && job.samples_per_second > 0 ? count(job.samples_per_second) + ' samples/s' : ''],
    ['Error (RMSE)', errorText(job)],
    ['Half-width', halfWidth],
    ...goals(job).map(targetRow),
    ['Ended by', job.state === 'done' ? endings[job.ended_by] : ''],
    ['Submitted', when(job.submitted)],
    ['Started', when(job.started)],
    ['Finished', when(job.finished)],
    ['Took', unfinished(job) && job.seconds_taken > 0 ? duration(job.seconds_taken) + ' so far' : ''],
    ['User', job.user],
    // Whoever may control the job has a field for the priority.
    ['Priority', unfinished(job) && !(mayControl(job, server) && permits(job, 'priority')) ? String(job.priority) : ''],
    ['Frame', job.frame !== undefined && typeof job.series === 'number' ? el('a', {href: `#/jobs/${job.series}`}, `${job.frame} in series ${job.series}`) : ''],
    ['Quick look of', known(job.preview_of) ? jobLink(job.preview_of) : '']];
}

/** Improves the texts of a history: no repeated state, usual words. Returns [{at, what}]. */
export function historyOf(events) {
  let started = false;
  return events.map(({at, what}) => {
    let text = what.replace(/^(\w+): (?=\1\b)/, '');
    if (text === 'begun') {
      text = started ? 'started again' : 'started';
      started = true;
    }
    return {at, what: text};
  });
}
