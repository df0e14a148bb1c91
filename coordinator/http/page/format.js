// Formats numbers and texts.

// A list formats a hundred numbers in a frame, so the formats are made once.
const rounded = Array.from({length: 4}, (_, digits) => new Intl.NumberFormat('en', {maximumSignificantDigits: Math.max(1, digits), useGrouping: false}));
const significant = (value, digits) => rounded[digits].format(value);
const momentFormat = new Intl.DateTimeFormat(undefined, {
  month: 'short', day: 'numeric', hour: '2-digit', minute: '2-digit', second: '2-digit', hourCycle: 'h23'});

/** Formats 12345678 as "12.3 M". */
export function count(value) {
  for (const [size, unit] of [[1e12, ' T'], [1e9, ' G'], [1e6, ' M'], [1e3, ' k']]) {
    if (value >= size) return (value / size).toPrecision(3) + unit;
  }
  return significant(value, 3);
}

/** Formats a number of bytes: "12 B", "12.3 MB". */
export const bytes = value => count(value) + (value < 1000 ? ' B' : 'B');

/** Formats 0.0000123 s as "12.3 µs". */
export function small(value, unit) {
  for (const [size, prefix] of [[1, ''], [1e-3, 'm'], [1e-6, 'µ']]) {
    if (value >= size) return `${(value / size).toPrecision(3)} ${prefix}${unit}`;
  }
  return `${(value / 1e-9).toPrecision(3)} n${unit}`;
}

/** Formats 1234567 as "1 234 567". */
export const whole = value => String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, ' ');

export const rate = perSecond => perSecond > 0 ? count(perSecond) + '/s' : '';

/** Formats a time as "3 min 20 s", which no line break divides. */
export const duration = seconds => timeText(seconds).replaceAll(' ', '\u00a0');

function timeText(seconds) {
  if (seconds < 0) return '';
  if (seconds < 10) return seconds.toFixed(1) + ' s';
  if (seconds < 59.5) return Math.round(seconds) + ' s';
  const minutes = Math.round(seconds / 60);
  if (seconds < 600) return `${Math.floor(seconds / 60)} min ${String(Math.floor(seconds % 60)).padStart(2, '0')} s`;
  if (minutes < 60) return minutes + ' min';
  if (minutes < 48 * 60) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`;
  return Math.round(minutes / 1440) + ' days';
}

/** Formats a share. Rounds down, so that unfinished jobs never show 100 %. */
export const percent = share => Math.floor(share * 1000) / 10 >= 100 ? '100 %' :
  (Math.floor(share * 1000) / 10).toFixed(share < 0.1 ? 1 : 0) + ' %';

const unknown = value => value === null || value === undefined;

/** Formats a requested error. */
export const radiance = value => unknown(value) ? 'unknown' : significant(value, 3);

/** Formats an estimate with three digits, including zeros, so that columns are aligned. */
export function estimate(value) {
  if (unknown(value)) return 'unknown';
  return value > 0 && value < 1e-4 ? value.toExponential(2) : value.toFixed(Math.max(0, 2 - Math.floor(Math.log10(value || 1))));
}

/** Formats a colour channel with the precision of a float. */
export const channel = value => Number.isFinite(value) ? value.toPrecision(6) : String(value);

export const moment = seconds => momentFormat.format(seconds * 1000);

export const unfinished = job => ['queued', 'running', 'paused', 'finishing'].includes(job.state);

/** Formats 3 as "3rd". */
export function nth(number) {
  const teen = number % 100 >= 11 && number % 100 <= 13;
  return number + (teen ? 'th' : {1: 'st', 2: 'nd', 3: 'rd'}[number % 10] ?? 'th');
}

/** Formats a number with its noun: "1 job", "12 jobs". */
export const counted = (number, noun) => `${whole(number)} ${noun}${number === 1 ? '' : 's'}`;

const highestLimit = 2 ** 24;  // what older servers state if no limit is set

/** Returns the limit of samples per pixel, or null without one. */
export const sampleLimit = job => job.samples_per_pixel >= highestLimit ? null : job.samples_per_pixel ?? null;

const samples = value => value < 10 ? String(Math.round(value * 10) / 10) : whole(value);

/** Formats the samples per pixel of a job: those taken if it has ended or has no limit, otherwise the limit. */
export function samplesOf(job) {
  const limit = sampleLimit(job);
  if (job.samples_taken > 0 && (limit === null || !unfinished(job))) return samples(job.samples_taken);
  return limit > 0 ? whole(limit) : '';
}

/** Returns the targets of a job: [{kind, now, asked}]. As in parray jobs, the current RMSE is the upper end of
 *  its confidence interval. */
export function goals(job) {
  const all = [];
  if (job.target_error > 0) all.push({kind: 'RMSE', now: job.error?.high, asked: job.target_error});
  if (job.target_half_width > 0) all.push({kind: 'half-width', now: job.error?.half_width_p99, asked: job.target_half_width});
  return all;
}

/** Returns the target that a job has reached, or else its first target, or undefined without a target. */
export function goal(job) {
  const all = goals(job);
  return all.find(({now, asked}) => now > 0 && now <= asked) ?? all[0];
}

/** Formats the error of a job: "0.021 (target 0.01)", or the error alone if the job has no target. */
export function errorOfGoal(job) {
  const to = goal(job);
  if (to) return `${unknown(to.now) ? '?' : estimate(to.now)} (target ${radiance(to.asked)})`;
  return unknown(job.error?.rmse) ? '' : estimate(job.error.rmse);
}

/** Returns the name of a file without directories and extension. */
export const stem = file => file.replace(/^.*[\\/]/, '').replace(/(\.gz)?$/i, '').replace(/\.[^.]+$/, '');
