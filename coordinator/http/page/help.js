// The dialog "Help": keys, words, and where to read more.

import {ask, button, el} from './dom.js';
import {canNotify, notices, switchNotices} from './notices.js';

const otherKeys = [['/', 'in a list: search'], ['↑ ↓ Page Home End', 'in a list: move between rows; Enter opens a row'],
  ['x, Space', 'in the list of jobs: choose the row; with Shift and an arrow key choose several'], ['Esc', 'in the list of jobs: choose no row'],
  ['+ −', 'in a picture: zoom'], ['0', 'in a picture: fit to the window'], ['1', 'in a picture: show pixels at their real size'],
  ['← → ↑ ↓', 'in a picture: move to another pixel; with Shift by ten pixels'], ['[ ]', 'in a picture: change the exposure'],
  ['m', 'in a picture: show the next map (error, cost, workers)'],
  ['Space ← →', 'in a series: play or stop; show the previous or the next frame'], [', .', 'in a frame: open the previous or the next frame']];
const glossary = [
  ['error (RMSE)', 'Estimated root mean square error of the picture in linear values. A job with a target error ends when the upper end of the error\u2019s 95 % interval is below the target.'],
  ['half-width', 'Half the width of a pixel\u2019s 95 % confidence interval. “99 % within 0.02” means that 99 % of the pixel values, each channel counted, have a smaller half-width.'],
  ['spp', 'Samples per pixel. More samples make a smaller error: four times as many halve it.'],
  ['lease', 'A part of a picture that a worker traces. When the worker is lost, another worker gets the lease.'],
  ['drain', 'A drained worker finishes its leases and gets no more. “Resume” ends this.'],
  ['quarantine', 'A machine that returned wrong results gets no more leases. “Resume” ends this. If the machine has no key of its own, it also ends by itself after a day.'],
  ['requeue', 'A failed or cancelled job returns to the queue and continues from its stored samples.'],
  ['quick look', 'A small, fast picture of a job that is shown until the job has its own samples.'],
  ['series', 'An animation: one job for each frame, controlled together.']];

export const lettersOff = () => localStorage.getItem('parray-keys') === 'off';
const rows = pairs => pairs.flatMap(([key, text]) => [el('dt', {}, el('kbd', {}, key)), el('dd', {}, text)]);
const words = pairs => pairs.flatMap(([word, text]) => [el('dt', {}, word), el('dd', {}, text)]);

/** Shows the dialog. `keys`: [[key, text]] that work in all views. `server`: the answer of GET /server, or undefined. */
export function showHelp(keys, server) {
  const letters = el('input', {type: 'checkbox', checked: !lettersOff(), onchange: event =>
    event.target.checked ? localStorage.removeItem('parray-keys') : localStorage.setItem('parray-keys', 'off')});
  const notice = el('input', {type: 'checkbox', checked: notices(), onchange: async () => { notice.checked = await switchNotices(notice.checked); }});
  return ask('Help', close => [
    el('h2', {}, 'Keyboard shortcuts'),
    el('dl', {class: 'keys'}, ...rows([...keys, ...otherKeys])),
    el('p', {}, 'In a picture, zoom with the wheel or two fingers, drag to move, and double-click to zoom in and out.'),
    el('div', {class: 'checks'}, el('label', {class: 'check'}, letters, 'Enable keyboard shortcuts'),
      canNotify() ? el('label', {class: 'check'}, notice, 'Notify me when my jobs have ended') : ''),
    el('details', {}, el('summary', {}, 'Glossary'), el('dl', {class: 'words'}, ...words(glossary))),
    el('p', {}, el('a', {href: 'api', target: '_blank', rel: 'noopener'}, 'HTTP interface'), ' of this server, as ',
      el('a', {href: 'api/v1/openapi.json', target: '_blank', rel: 'noopener'}, 'OpenAPI'),
      `. ParRay${server?.version ? ' ' + server.version : ''}: README.md explains the programs, coordinator/FARM.md explains the farm.`),
    el('div', {class: 'answers'}, button('Close', () => close(), {autofocus: true}))], 'wide');
}
