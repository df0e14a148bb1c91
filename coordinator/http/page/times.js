// Shows moments and durations of jobs.

import {el} from './dom.js';
import {duration, moment} from './format.js';

/** Formats how long ago a moment is: "3 min ago". `seconds`: since 1970. */
export function ago(seconds) {
  const passed = Date.now() / 1000 - seconds;
  if (passed < 10) return 'just now';
  if (passed < 59.5) return `${Math.round(passed)} s ago`;
  if (passed < 3600) return `${Math.floor(passed / 60)} min ago`;
  if (passed < 86400) return `${Math.floor(passed / 3600)} h ago`;
  return passed < 2 * 86400 ? 'yesterday' : moment(seconds).replace(/:\d\d$/, '');
}

/** Creates an element with "3 min ago"; its title is the exact time. Nothing for null. `before`: text in front. */
export function when(seconds, before = '') {
  if (!(seconds > 0)) return undefined;
  const date = new Date(seconds * 1000);
  return el('time', {datetime: date.toISOString(), title: date.toLocaleString()}, before + ago(seconds));
}

/** Formats an estimate: "about 4 min". */
export const about = seconds => seconds < 60 ? `about ${Math.max(1, Math.round(seconds))} s` : 'about ' + duration(seconds).replace(/ \d\d s$/, '');
