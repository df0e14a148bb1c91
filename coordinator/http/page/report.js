// Shows the report of a done job: groups, most important first, without what says nothing.

import {button, el, facts, notify} from './dom.js';

const groups = [  // [title, names of the report or their first parts]
  ['Picture', ['width', 'height', 'spheres', 'samples_per_pixel', 'least_samples', 'most_samples', 'adaptive', 'sampler', 'seed', 'max_depth',
    'features', 'filled_pixels', 'fill_block']],
  ['Error', ['error', 'denoised', 'target_error', 'target_half_width', 'target_denoised', 'time_limit', 'stopped_by', 'checked_share',
    'nonfinite_samples', 'nonfinite_pixels', 'nonfinite', 'flag']],
  ['Time', ['seconds', 'threads', 'workers', 'samples', 'samples_per_second', 'rays', 'rays_per_second', 'passes', 'schedule', 'row_order',
    'accelerator', 'accelerator_bytes', 'duplicates_removed']],
  ['Bits', ['image_sha256', 'scene_sha256', 'precision', 'precision_reason', 'isa', 'version', 'trace_version']]];

/** Copies a text without the clipboard interface, which browsers offer to https and localhost only. */
function copySelected(text) {
  const field = el('textarea', {class: 'unseen', readonly: true, 'aria-hidden': 'true'});
  field.value = text;
  const focused = document.activeElement;
  document.body.append(field);
  field.select();
  const done = document.execCommand('copy');
  field.remove();
  focused?.focus();
  return done;
}

/** Copies a text, and says so. `what`: a noun phrase. */
export async function copy(text, what) {
  try {
    if (navigator.clipboard) await navigator.clipboard.writeText(text);
    else if (!copySelected(text)) throw new Error();
    notify(`Copied ${what}.`);
  } catch {
    notify(`The browser does not permit copying. Select ${what} instead.`, 'error');
  }
}

const empty = value => value === null || value === 0 || value === '' || value === false || Array.isArray(value) && !value.length;

function textOf(value) {
  if (Array.isArray(value)) return value.some(item => item instanceof Object) ? `${value.length} entries` : value.join(', ');
  return typeof value === 'number' && !Number.isInteger(value) ? String(Number(value.toPrecision(6))) : value === true ? 'yes' : String(value);
}

/** Returns [[path, text]] of what a value contains. */
function flatten(value, path) {
  if (empty(value)) return [];
  if (value instanceof Object && !Array.isArray(value)) {
    return Object.entries(value).flatMap(([name, inner]) => flatten(inner, `${path}.${name}`));
  }
  return [[path, textOf(value)]];
}

function copyable([path, text]) {
  if (!path.endsWith('_sha256')) return [path, text];
  return [path, el('span', {class: 'copyable'}, el('span', {}, text), button('Copy', () => copy(text, path), {'aria-label': `Copy ${path}`}))];
}

/** Returns an element with the report, closed. */
export function reportOf(report) {
  const rest = Object.keys(report).filter(name => !groups.some(([, names]) => names.includes(name)));
  const parts = [...groups, ['Other', rest]].map(([title, names]) =>
    [title, names.flatMap(name => flatten(report[name] ?? null, name)).map(copyable)]).filter(([, pairs]) => pairs.length);
  return el('details', {class: 'report'}, el('summary', {}, 'Report'), ...parts.flatMap(([title, pairs]) => {
    const list = facts(pairs);
    list.classList.add('raw');
    return [el('h3', {}, title), list];
  }));
}

const quoted = file => `'${file.replaceAll("'", "'\\''")}'`;

/** Returns an element with the command that renders the same picture from its downloaded PNG file. */
export function recipeOf(file) {
  const command = `parray render --like ${quoted(file)} SCENE -o again.png`;
  return el('details', {class: 'recipe'}, el('summary', {}, 'Render it again'),
    el('p', {}, 'The PNG contains its recipe. This command renders the same bits from the downloaded PNG and the scene:'),
    el('div', {class: 'command'}, el('pre', {tabindex: 0, 'aria-label': 'Command'}, command),
      button('Copy', () => copy(command, 'the command'), {'aria-label': 'Copy the command'})));
}
