// The view that submits a scene or particle files as a job.

import {submit} from './api.js';
import {button, el, setText} from './dom.js';
import {bytes, stem} from './format.js';
import {rememberQuickLook} from './quick_look.js';

const quickWidth = 300;
const quickSamples = 16;
const largestRead = 64e6;  // bytes; larger scenes are not read for the size of the picture

const number = (name, text, more = {}) => ({name, text, type: 'number', ...more});
const plain = [
  {name: 'name', text: 'Name', type: 'text', maxlength: 128, hint: 'from the file'},
  number('width', 'Width', {min: 1, hint: 'from the scene'}), number('height', 'Height', {min: 1, hint: 'from the scene'}),
  number('spp', 'Samples per pixel', {min: 1, hint: 'from the scene'}),
  number('target_error', 'Target: error (RMSE)', {min: 0, step: 'any', hint: 'none'}),
  number('target_half_width', 'Target: half-width', {min: 0, step: 'any', hint: 'none'}),
  number('time_limit', 'Time limit in seconds', {min: 0, step: 'any', hint: 'none'}),
  number('priority', 'Priority, 0 to 100', {min: 0, max: 100, hint: '50'})];
const further = [
  number('max_depth', 'Max. ray segments per path', {min: 1, hint: 'from the scene'}), number('seed', 'Seed', {min: 0, hint: 'from the scene'}),
  {name: 'sampler', text: 'Sampler', choices: ['', 'independent', 'sobol']},
  {name: 'precision', text: 'Precision', choices: ['', 'auto', 'f32', 'mixed', 'f64']},
  {name: 'schedule', text: 'Schedule', choices: ['', 'static', 'guided', 'factoring', 'weighted']},
  {name: 'webhook', text: 'Webhook when finished', type: 'url', hint: 'none'}];

function field({name, text, choices, hint, ...attributes}) {
  const input = choices ?
    el('select', {name}, ...choices.map(choice => el('option', {value: choice}, choice || 'default'))) :
    el('input', {name, placeholder: hint, autocomplete: 'off', ...attributes});
  return el('label', {class: 'field'}, el('span', {}, text), input);
}

const check = (name, text, checked) => el('label', {class: 'check'}, el('input', {type: 'checkbox', name, checked}), text);

const isScene = file => /\.json$/i.test(file.name);
const freshKey = () => 'page-' + Array.from(crypto.getRandomValues(new Uint8Array(16)), byte => byte.toString(16).padStart(2, '0')).join('');

/** Returns the size of the picture from the scene, or the default: {width, height}. */
async function shapeOf(scene) {
  const usual = scene ? {width: 1200, height: 800} : {width: 1200, height: 900};
  if (!scene || scene.size > largestRead) return usual;
  try {
    const {image} = JSON.parse(await scene.text());
    return image?.width > 0 && image?.height > 0 ? image : usual;
  } catch {
    return usual;  // the server reports the error
  }
}

export class SubmitView {
  title = 'Submit';
  #farm;
  #scene;
  #files = [];
  #keys = {};  // idempotency keys: a repeated attempt with the same files and options creates no second job

  constructor(farm) {
    this.#farm = farm;
    this.input = el('input', {type: 'file', multiple: true, id: 'files', onchange: () => {
      this.add(this.input.files);
      this.input.value = '';
    }});
    this.list = el('ul', {class: 'files'});
    this.zone = el('div', {class: 'drop'}, el('p', {}, el('label', {for: 'files', class: 'button'}, 'Choose files'), this.input, ' or drop them anywhere on the page'),
      el('p', {class: 'hint'}, 'A scene (JSON) with the files that it refers to, or a particle file: PLY, CSV, XYZ, LAMMPS dump, PDB, mmCIF and others, also with .gz'), this.list);
    this.quick = check('quick', `Quick look first: ${quickWidth} pixels wide, ${quickSamples} samples per pixel`, true);
    this.problem = el('p', {class: 'trouble', role: 'alert', hidden: true});
    this.progress = el('progress', {max: 1, hidden: true, 'aria-label': 'Upload'});
    this.send = el('button', {type: 'submit', class: 'primary'}, 'Submit');
    this.form = el('form', {oninput: () => this.#changed(), onsubmit: event => this.#submit(event)}, this.zone,
      el('div', {class: 'fields'}, ...plain.map(field)),
      el('div', {class: 'checks'}, this.quick),
      el('details', {}, el('summary', {}, 'More options'), el('div', {class: 'fields'}, ...further.map(field))),
      this.problem, el('div', {class: 'answers'}, this.progress, this.send));
    this.element = el('section', {class: 'view submit', 'aria-labelledby': 'submit-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'submit-title', tabindex: -1}, 'Submit a scene')), this.form);
    this.#showFiles();
  }

  show() {}
  update() {}

  add(files) {
    for (const file of files) {
      if (isScene(file)) this.#scene = file;
      else this.#files = [...this.#files.filter(other => other.name !== file.name), file];
    }
    this.#changed();
    this.#showFiles();
  }

  #changed() {
    this.#keys = {};
    this.problem.hidden = true;
  }

  #remove(file) {
    if (file === this.#scene) this.#scene = undefined;
    this.#files = this.#files.filter(other => other !== file);
    this.#changed();
    this.#showFiles();
    this.input.focus();
  }

  #showFiles() {
    const all = [...this.#scene ? [this.#scene] : [], ...this.#files];
    this.list.replaceChildren(...all.map(file => el('li', {},
      el('span', {class: 'what'}, file === this.#scene ? 'scene' : 'particles'), el('span', {class: 'file'}, file.name),
      el('span', {}, bytes(file.size)), button('Remove', () => this.#remove(file), {'aria-label': `Remove ${file.name}`, class: 'quiet'}))));
    this.send.disabled = all.length === 0;
    const namePlace = this.form.elements.name;
    namePlace.placeholder = all.length ? stem(all[0].name) : 'from the file';
  }

  #options() {
    const options = {};
    for (const {name, type} of [...plain, ...further]) {
      const text = this.form.elements[name].value.trim();
      if (text !== '') options[name] = type === 'number' ? Number(text) : text;
    }
    options.name ??= stem((this.#scene ?? this.#files[0]).name).slice(0, 128);
    options.progressive = true;  // the page shows the picture while it grows
    return options;
  }

  async #quickOptions({name, sampler, precision, max_depth, seed, priority = 50, ...rest}) {
    const shape = await shapeOf(this.#scene);
    const width = rest.width ?? shape.width;
    const height = rest.height ?? shape.height;
    const known = {sampler, precision, max_depth, seed};
    return {...Object.fromEntries(Object.entries(known).filter(([, value]) => value !== undefined)),
      name: name.slice(0, 115) + ' (quick look)', width: Math.min(quickWidth, width), progressive: true,
      height: Math.max(1, Math.round(Math.min(quickWidth, width) * height / width)),
      spp: Math.min(quickSamples, rest.spp ?? quickSamples), priority: Math.min(100, priority + 1)};
  }

  async #submit(event) {
    event.preventDefault();
    this.send.disabled = true;
    this.problem.hidden = true;
    this.progress.hidden = false;
    try {
      const options = this.#options();
      const quick = this.form.elements.quick.checked ? await this.#post('quick', await this.#quickOptions(options)) : undefined;
      const id = await this.#post('whole', options);
      if (quick) rememberQuickLook(id, quick);
      this.#scene = undefined;
      this.#files = [];
      this.#keys = {};
      location.hash = `#/jobs/${id}`;
    } catch (problem) {
      setText(this.problem, problem.message);
      this.problem.hidden = false;
    }
    this.progress.hidden = true;
    this.#showFiles();
  }

  #post(which, options) {
    const most = this.#farm.server?.limits.body_bytes;
    const size = [this.#scene, ...this.#files].reduce((sum, file) => sum + (file?.size ?? 0), 0);
    if (size > most) throw new Error(`The files have ${bytes(size)}. The limit of this server is ${bytes(most)}.`);
    this.#keys[which] ??= freshKey();
    this.progress.value = 0;
    return submit({scene: this.#scene, files: this.#files, options, key: this.#keys[which],
      progress: share => { this.progress.value = share; }});
  }
}
