// Shows the report of a done job: groups, most important first, without what says nothing.

import {el, facts} from './dom.js';
import {command} from './parts.js';

const groups = [  // [title, names of the report or their first parts]
  ['Picture', ['width', 'height', 'spheres', 'samples_per_pixel', 'least_samples', 'most_samples', 'adaptive', 'sampler', 'seed', 'max_depth',
    'features', 'filled_pixels', 'fill_block']],
  ['Error', ['error', 'denoised', 'target_error', 'target_half_width', 'target_denoised', 'time_limit', 'stopped_by', 'checked_share',
    'nonfinite_samples', 'nonfinite_pixels', 'nonfinite', 'flag']],
  ['Time', ['seconds', 'threads', 'workers', 'samples', 'samples_per_second', 'rays', 'rays_per_second', 'passes', 'schedule', 'row_order',
    'accelerator', 'accelerator_bytes', 'duplicates_removed']],
  ['Bits', ['image_sha256', 'scene_sha256', 'precision', 'precision_reason', 'isa', 'version', 'trace_version']]];

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

/** Returns an element with the report, closed. */
export function reportOf(report) {
  const rest = Object.keys(report).filter(name => !groups.some(([, names]) => names.includes(name)));
  const parts = [...groups, ['Other', rest]].map(([title, names]) =>
    [title, names.flatMap(name => flatten(report[name] ?? null, name)).map(([path, text]) => [path, path.endsWith('_sha256') ? command(text) : text])]).filter(([, pairs]) => pairs.length);
  return el('details', {class: 'report'}, el('summary', {}, 'Report'), ...parts.flatMap(([title, pairs]) => {
    const list = facts(pairs);
    list.classList.add('raw');
    return [el('h2', {}, title), list];
  }));
}

const quoted = file => `'${file.replaceAll("'", "'\\''")}'`;

/** Returns an element with the command that renders the same picture from its downloaded PNG file. */
export function recipeOf(file) {
  return el('details', {class: 'recipe'}, el('summary', {}, 'Render it again'),
    el('p', {}, 'The PNG contains its recipe. This command renders the same bits from the downloaded PNG and the scene:'),
    command(`parray render --like ${quoted(file)} SCENE -o again.png`));
}
