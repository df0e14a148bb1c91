// The fields of the form that submits jobs: what they are called, and what they mean as options of a job. The server's
// description of its options (openapi.json) gives the choices and the least and greatest numbers.

import {el, setText} from './dom.js';

const number = (name, text, more = {}) => ({name, text, type: 'number', ...more});
const word = (name, text, hint, more = {}) => ({name, text, hint, type: 'text', ...more});
const choice = (name, text, more = {}) => ({name, text, choice: true, ...more});

export const pictureFields = [
  word('name', 'Name', 'from the file', {maxlength: 128}),
  choice('quality', 'Quality', {title: 'draft: half as wide and high, error 0.05, denoised. good: error 0.02. print: twice as wide and high, error 0.005'}),
  number('width', 'Width', {hint: 'from the scene'}), number('height', 'Height', {hint: 'from the scene'}),
  number('spp', 'Samples per pixel', {hint: 'from the scene'}),
  number('time_limit', 'Time limit in seconds', {min: 0, step: 'any', hint: 'none'}),
  number('priority', 'Priority, 0 to 100', {hint: '50'})];

export const furtherFields = [
  number('max_depth', 'Max. ray segments per path', {hint: 'from the scene'}), number('seed', 'Seed', {hint: 'from the scene'}),
  choice('sampler', 'Sampler'), choice('precision', 'Precision'), choice('schedule', 'Schedule'),
  number('max_failures', 'Failed machines that end the job', {hint: 'from the farm',
    title: 'The job fails if so many machines that trace other parts of it have failed at the same part. It also fails if all machines have failed there, and they are so many, or each has at least two failures for each of its workers'}),
  {name: 'webhook', text: 'Webhook when finished', type: 'url', hint: 'none'}];

export const particleFields = [
  choice('style', 'Style', {usual: 'studio'}),
  choice('view', 'View', {usual: 'auto'}),
  word('background', 'Background', 'of the style', {title: 'white, black, grey or #RRGGBB'}),
  word('select', 'Selection', 'all particles', {title: 'For example: chain A and not water; element C N O; within 5 of resname HEM', wide: true}),
  word('color_by', 'Colour by', 'automatic', {list: ['element', 'type', 'chain', 'residue', 'atom', 'x', 'y', 'z', 'radius', 'index', 'resid', 'b_factor', 'charge', 'vx'],
    title: 'A category, or any number of the particles'}),
  choice('colormap', 'Colour map', {usual: 'viridis'}),
  word('range', 'Range of colours', 'lowest:highest', {title: 'Two numbers such as 0:5, or percentiles such as 1%:99%'}),
  word('radius', 'Radius', 'from the file', {title: 'A number, by-element, covalent or column', numeric: true}),
  choice('crystal', 'Crystal', {title: 'on: covalent radii, copies of the atoms on the faces of the cell, and the cell', onOff: true}),
  word('replicate', 'Repeat the cell', '1x1x1', {pattern: '\\d+x\\d+x\\d+', title: 'Copies along the edges a, b, c, such as 3x3x2'}),
  word('frames', 'Frames', 'one picture', {title: 'Frames of a trajectory: all, or FIRST:LAST:STEP such as 0:100:5. They become one job, a series'})];

export const targets = [
  {value: '', text: 'no target'},
  {value: 'target_error', text: 'error (RMSE)', label: 'Target error (RMSE)', hint: '0.02'},
  {value: 'target_half_width', text: 'half-width', label: 'Target half-width of 99 % of the values', hint: '0.03'}];

const allFields = [...pictureFields, ...furtherFields, ...particleFields, {name: 'denoise', text: 'Denoise'}, {name: 'legend', text: 'Legend'},
  ...targets.slice(1).map(({value, label}) => ({name: value, text: label}))];

export function field({name, text, choice, usual, hint, list, title, wide, numeric, onOff, ...attributes}) {
  const id = list && 'list-of-' + name;
  const input = choice ? el('select', {name}, el('option', {value: ''}, usual ?? 'default')) :
    el('input', {name, placeholder: hint, autocomplete: 'off', spellcheck: 'false', list: id, ...attributes});
  return el('label', {class: wide ? 'field wide' : 'field', title}, el('span', {}, text), input,
    list && el('datalist', {id}, ...list.map(value => el('option', {value}))));
}

export const check = (name, text, more = {}) => el('label', {class: 'check'}, el('input', {type: 'checkbox', name, ...more}), text);

/** Returns the option that the field asks for, or undefined. */
function valueOf({type, numeric, onOff}, input) {
  const text = input.value.trim();
  if (text === '' || input.disabled) return undefined;
  if (onOff) return text === 'on';
  return type === 'number' || (numeric && Number.isFinite(Number(text))) ? Number(text) : text;
}

const choicesOf = ({type, enum: values, examples}) => type === 'boolean' ? ['on', 'off'] : values ?? examples ?? [];

/** Adds the choices that the server describes. Does so once, and keeps what the user chose. */
function addChoices(select, usual, described) {
  if (select.options.length > 1) return;
  select.append(...choicesOf(described).filter(value => value !== usual).map(value => el('option', {value}, value)));
}

/** Gives the fields what the server describes: choices, and least and greatest numbers. `options` is undefined if the
 * server did not answer. Hides the fields of options for which `taken(name)` is false, and choices without a choice. */
export function describeFields(form, options, taken) {
  for (const {name, choice, usual} of allFields) {
    const input = form.elements[name];
    const described = options?.[name];
    if (!input) continue;
    if (choice && described) addChoices(input, usual, described);
    if (described?.minimum !== undefined) input.min = described.minimum;
    if (described?.maximum !== undefined) input.max = described.maximum;
    input.disabled = input.closest('label').hidden = !taken(name) || (Boolean(choice) && input.options.length < 2);
  }
}

/** Adds the options that `fields` ask for to `options`. */
export function readFields(form, fields, options) {
  for (const description of fields) {
    const value = valueOf(description, form.elements[description.name]);
    if (value !== undefined) options[description.name] = value;
  }
}

/** The choice of a target: none, or one of two kinds and its value. */
export class TargetChoice {
  constructor() {
    this.label = el('span', {});
    this.input = el('input', {name: 'target', type: 'number', min: 0, step: 'any', autocomplete: 'off'});
    this.field = el('label', {class: 'field'}, this.label, this.input);
    this.radios = targets.map(({value, text}) => el('label', {}, el('input', {type: 'radio', name: 'target_kind', value, checked: value === '',
      onchange: () => this.#show()}), el('span', {}, text)));
    this.element = el('div', {class: 'target'}, el('fieldset', {class: 'choice'}, el('legend', {class: 'unseen'}, 'Stop at'), ...this.radios), this.field);
    this.#show();
  }
  get kind() {
    return this.radios.map(radio => radio.firstChild).find(radio => radio.checked).value;
  }
  #show() {
    const {value, label = '', hint = ''} = targets.find(target => target.value === this.kind);
    setText(this.label, label);
    this.input.placeholder = hint;
    this.input.disabled = !value;
    this.input.required = Boolean(value);
    this.field.hidden = !value;
  }
  read(options) {
    if (this.kind) options[this.kind] = Number(this.input.value);
  }
}

/** Returns the name of the option that an error message is about, and the message without its pointer. */
export function optionOf(message) {
  const found = message.match(/^options: \/([a-z_]+)[^:]*: (.*)$/s) ?? message.match(/^--([a-z-]+): (.*)$/s);
  if (!found) return undefined;
  const name = found[1].replaceAll('-', '_');
  const known = allFields.find(description => description.name === name);
  return known && {name, text: `${known.text}: ${found[2]}`};
}
