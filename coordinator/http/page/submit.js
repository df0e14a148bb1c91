// The view that submits scenes and particle files as jobs.

import {getJson, submit} from './api.js';
import {button, confirm, el, notify, setText} from './dom.js';
import {day, forecastText, hour, mayTakeLong, roughly, secondsOf} from './forecast.js';
import {bytes, stem} from './format.js';
import {jobLink} from './parts.js';
import {quickLookOptions, quickSamples, quickWidth, rememberQuickLook} from './quick_look.js';
import {check, describeFields, field, furtherFields, optionOf, particleFields, pictureFields, readFields, TargetChoice} from './submit_fields.js';
import {ChosenFiles} from './submit_files.js';

const patience = 8000;  // ms that a job waits for its own forecast before it is submitted
const largestForecast = 64e6;  // bytes; larger files are not sent twice

const freshKey = () => 'page-' + Array.from(crypto.getRandomValues(new Uint8Array(16)), byte => byte.toString(16).padStart(2, '0')).join('');
const nameOf = job => stem(job.lead.file.name).slice(0, 128);
const sizeOf = ({lead, parts}) => [lead, ...parts].reduce((sum, {file}) => sum + file.size, 0);

export class SubmitView {
  title = 'Submit';
  #farm;
  #files = new ChosenFiles(() => this.#showFiles());
  #keys = new Map();  // idempotency keys: a repeated attempt with the same files and options creates no second job
  #status = new Map();  // by the first file of a job: {text, kind} or {progress}
  #plans = new Map();  // forecasts by the first file of a job
  #canForecast = true;
  #described;  // the server's descriptions of the options that it takes; undefined: not known
  #busy = false;

  constructor(farm) {
    this.#farm = farm;
    this.input = el('input', {type: 'file', multiple: true, id: 'files', onchange: () => {
      this.add(this.input.files);
      this.input.value = '';
    }});
    this.list = el('ul', {class: 'jobs-to-submit'});
    this.zone = el('div', {class: 'drop'}, el('p', {}, el('label', {for: 'files', class: 'button'}, 'Choose files'), this.input, ' or drop them anywhere on the page'),
      el('p', {class: 'hint'}, 'Scenes (JSON) with the files that they refer to, or particle files: PLY, CSV, XYZ, LAMMPS, PDB, mmCIF, GRO, SDF, MOL2, POSCAR, GSD, DCD, XTC, TRR and others, also compressed. Several of them become several jobs.'));
    this.submitted = el('p', {class: 'submitted', role: 'status', hidden: true});
    this.problem = el('p', {class: 'trouble', role: 'alert', id: 'submit-problem', hidden: true});
    this.forecast = el('p', {class: 'forecast', role: 'status'});
    this.notes = el('p', {class: 'hint notes-of-forecast'});
    this.progress = el('progress', {max: 1, hidden: true, 'aria-label': 'Upload'});
    this.plan = button('Forecast', () => this.#showForecast(), {title: 'Estimate how long this would take on this farm'});
    this.send = el('button', {type: 'submit', class: 'primary'}, 'Submit');
    this.form = el('form', {oninput: () => this.#changed(), onsubmit: event => this.#submit(event)}, ...this.#parts());
    this.element = el('section', {class: 'view submit', 'aria-labelledby': 'submit-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'submit-title', tabindex: -1}, 'Submit a scene')), this.form);
    this.#fitFields();
  }

  #parts() {
    this.target = new TargetChoice();
    this.particles = el('fieldset', {class: 'group', hidden: true}, el('legend', {}, 'Particles'), el('div', {class: 'fields'}, ...particleFields.map(field)),
      el('div', {class: 'checks'}, check('legend', 'Legend of the colours')));
    this.more = el('details', {}, el('summary', {}, 'More options'), el('div', {class: 'fields'}, ...furtherFields.map(field)));
    return [this.zone, this.list, this.submitted,
      el('fieldset', {class: 'group'}, el('legend', {}, 'Picture'), el('div', {class: 'fields'}, ...pictureFields.map(field)), this.target.element,
        el('div', {class: 'checks'}, check('quick', `Quick look first: ${quickWidth} pixels wide, ${quickSamples} samples per pixel`, {checked: true}), check('denoise', 'Denoise'))),
      this.particles, this.more,
      el('div', {class: 'foot'}, this.problem, el('div', {class: 'answers'}, this.forecast, this.progress, this.plan, this.send), this.notes)];
  }

  show() {
    this.#fitFields();
    this.#loadOptions();
  }

  update(changes) {
    if (!changes.connection) return;
    this.#fitFields();
    this.#loadOptions();
  }

  add(files) {
    this.#files.add(files);
    this.submitted.hidden = true;
    this.#changed();
    this.#showFiles();
  }

  #changed() {
    this.#keys.clear();
    this.#plans.clear();
    this.#status.clear();
    setText(this.forecast, '');
    setText(this.notes, '');
    this.#showProblem();
    setText(this.form.elements.spp.previousSibling, this.target.kind ? 'Max. samples' : 'Samples per pixel');
    this.#showPlaceholders(this.#files.jobs());
  }

  #takes(option) {
    return !this.#described || option in this.#described;
  }

  /** Reads which options the server takes, and what they accept. */
  async #loadOptions() {
    if (this.#described || !this.#farm.server) return;
    try {
      const {paths, components} = await getJson('openapi.json');
      this.#described = components.schemas.Options.properties;
      this.#canForecast = '/api/v1/plan' in paths;
    } catch {
      return;  // the form shows all fields, and the server reports wrong ones
    }
    this.#fitFields();
  }

  /** Fits the fields to what the server takes. It takes webhooks only if it permits a host. */
  #fitFields() {
    const taken = name => this.#takes(name) && (name !== 'webhook' || this.#farm.server?.webhooks === true);
    describeFields(this.form, this.#described, taken);
    this.#showFiles();
  }

  #remove(entry) {
    this.#files.remove(entry);
    this.#changed();
    this.#showFiles();
    this.input.focus();
  }

  #showFiles() {
    const jobs = this.#files.jobs();
    this.list.replaceChildren(...jobs.map(job => this.#jobRow(job)));
    this.list.hidden = !jobs.length;
    this.send.disabled = this.plan.disabled = !jobs.length || this.#busy;
    this.plan.hidden = !this.#canForecast;
    setText(this.send, jobs.length > 1 ? `Submit ${jobs.length} jobs` : 'Submit');
    this.particles.hidden = jobs.every(({lead}) => lead.scene) || !particleFields.some(({name}) => this.#takes(name));
    this.#showPlaceholders(jobs);
  }

  #jobRow(job) {
    const status = this.#status.get(job.lead);
    const said = status?.progress !== undefined ? el('progress', {max: 1, value: status.progress, 'aria-label': `Upload of ${job.lead.file.name}`}) :
      status?.text ? el('p', {class: status.kind}, status.text) : undefined;
    return el('li', {}, this.#fileRow(job.lead, job.lead.scene ? 'scene' : 'particles'), ...job.parts.map(entry => this.#fileRow(entry, job.lead.scene ? 'part' : 'topology')),
      job.missing.length ? el('p', {class: 'missing'}, `The scene refers to ${job.missing.slice(0, 5).join(', ')}${job.missing.length > 5 ? ' and others' : ''}: add the file.`) : undefined, said);
  }

  #fileRow(entry, what) {
    return el('div', {class: ['part', 'topology'].includes(what) ? 'file-row piece' : 'file-row'}, el('span', {class: 'what'}, what), el('span', {class: 'file'}, entry.file.name), el('span', {class: 'bytes'}, bytes(entry.file.size)),
      this.#placeOf(entry), button('Remove', () => this.#remove(entry), {'aria-label': `Remove ${entry.file.name}`, class: 'quiet'}));
  }

  /** Creates the choice of what a particle file is for. */
  #placeOf(entry) {
    const users = this.#files.usersOf(entry);
    if (!users.length) return el('span', {});
    const owners = this.#files.ownersOf(entry);
    const places = [['own', 'a job of its own'], ...users.map((user, i) => [String(i), `${user.scene ? 'part' : 'topology'} of ${user.file.name}`])];
    if (owners.length > 1) places.unshift(['auto', `part of ${owners.length} scenes`]);
    const now = owners.length > 1 ? 'auto' : owners.length ? String(users.indexOf(owners[0])) : 'own';
    return el('select', {'aria-label': `Use of ${entry.file.name}`, onchange: event => {
      const {value} = event.target;
      entry.place = value === 'own' ? 'own' : value === 'auto' ? undefined : users[Number(value)];
      this.#changed();
      this.#showFiles();
    }}, ...places.map(([value, text]) => el('option', {value, selected: value === now}, text)));
  }

  /** Shows the numbers that apply without options. */
  #showPlaceholders(jobs) {
    const of = (read, usual) => {
      const found = new Set(jobs.map(read));
      return found.size === 1 ? String([...found][0] ?? usual) : usual;
    };
    const {name, width, height, spp, max_depth, seed} = this.form.elements;
    name.placeholder = of(nameOf, jobs.length ? 'from each file' : 'from the file');
    name.disabled = jobs.length > 1;
    width.placeholder = of(({numbers}) => numbers.width, 'from the scene');
    height.placeholder = of(({numbers}) => numbers.height, 'from the scene');
    spp.placeholder = this.target.kind ? 'no limit' : of(({lead, numbers}) => lead.scene ? numbers.samples_per_pixel : 'for error 0.02', 'from the scene');
    max_depth.placeholder = of(({numbers}) => numbers.max_depth, 'from the scene');
    seed.placeholder = of(({numbers}) => numbers.seed, 'from the scene');
  }

  /** Returns the options that the form asks for. */
  #options(job) {
    const options = {};
    const {elements} = this.form;
    readFields(this.form, [...pictureFields, ...furtherFields], options);
    this.target.read(options);
    if (elements.denoise.checked && !elements.denoise.disabled) options.denoise = true;
    if (!job.lead.scene) {
      readFields(this.form, particleFields, options);
      if (elements.legend.checked && !elements.legend.disabled) options.legend = true;
      if (job.parts.length) options.topology = job.parts[0].file.name;
    }
    options.name ??= nameOf(job);
    options.progressive = true;  // the page shows the picture while it grows
    return options;
  }

  async #submit(event) {
    event.preventDefault();
    await this.#work(async () => {
      const jobs = this.#files.jobs();
      this.#status.clear();
      if (!await this.#mayTake(jobs)) return;
      const ids = [];
      for (const job of jobs) {
        const id = await this.#submitOne(job, jobs.length > 1);
        if (id !== undefined) ids.push([job, id]);
      }
      this.#finish(jobs, ids);
    });
  }

  /** Runs `action` while the form accepts no second one. */
  async #work(action) {
    this.#busy = this.send.disabled = this.plan.disabled = true;
    this.#showProblem();
    await this.#files.ready();
    try {
      await action();
    } finally {
      this.#busy = false;
      this.progress.hidden = true;
      this.#showFiles();
    }
  }

  /** Submits a job, and then its quick look. Returns the number of the job, or undefined after an error. */
  async #submitOne(job, several) {
    const options = this.#options(job);
    const progress = share => this.#showProgress(job, share, several);
    try {
      progress(0);
      const {id} = await this.#post(job, 'whole', options, progress);
      if (this.form.elements.quick.checked && options.frames === undefined) await this.#submitQuickLook(job, options, id, progress);
      this.#status.delete(job.lead);
      return id;
    } catch (problem) {
      if (several) this.#status.set(job.lead, {text: optionOf(problem.message)?.text ?? problem.message, kind: 'trouble'});
      this.#showProblem(problem.message);
      return undefined;
    }
  }

  async #submitQuickLook(job, options, id, progress) {
    try {
      const small = quickLookOptions(options, job.numbers, id);
      if (!this.#takes('preview_of')) delete small.preview_of;
      const quick = await this.#post(job, 'quick', small, progress);
      rememberQuickLook(id, quick.id);
    } catch (problem) {
      notify(`Job ${id} has no quick look: ${problem.message}`);  // the job itself was accepted
    }
  }

  #finish(jobs, ids) {
    if (ids.length === jobs.length) this.#keys.clear();
    for (const [job] of ids) for (const entry of [job.lead, ...job.parts]) this.#release(entry, jobs, ids);
    if (jobs.length === 1 && ids.length) {
      location.hash = `#/jobs/${ids[0][1]}`;
      return;
    }
    this.submitted.replaceChildren('Submitted: ', ...ids.flatMap(([job, id], i) => [i ? ', ' : '', jobLink(id), ` (${nameOf(job)})`]));
    this.submitted.hidden = !ids.length;
    if (jobs.length > 1 && ids.length < jobs.length) setText(this.problem, `${jobs.length - ids.length} of ${jobs.length} jobs failed to submit. The list of files shows the errors.`);
  }

  /** Removes a file whose jobs were all submitted. */
  #release(entry, jobs, ids) {
    const done = new Set(ids.map(([job]) => job));
    if (jobs.every(job => done.has(job) || ![job.lead, ...job.parts].includes(entry))) this.#files.remove(entry);
  }

  #showProgress(job, share, several) {
    this.progress.hidden = several;
    this.progress.value = share;
    if (!several) return;
    const before = this.#status.get(job.lead);
    this.#status.set(job.lead, {progress: share});
    const bar = before?.progress !== undefined && [...this.list.querySelectorAll('progress')].at(-1);
    if (bar) bar.value = share;
    else this.#showFiles();
  }

  /** Shows an error, and marks the field of the option that it names. No message: there is no error. */
  #showProblem(message = '') {
    for (const input of this.form.querySelectorAll('[aria-invalid]')) {
      input.removeAttribute('aria-invalid');
      input.removeAttribute('aria-describedby');
    }
    const option = optionOf(message);
    setText(this.problem, option?.text ?? message);
    this.problem.hidden = !message;
    const input = option && this.form.elements[option.name.startsWith('target_') ? 'target' : option.name];
    if (!input || input.disabled) return;
    input.setAttribute('aria-invalid', 'true');
    input.setAttribute('aria-describedby', 'submit-problem');
    const around = input.closest('details');
    if (around) around.open = true;
    input.focus();
  }

  #post(job, which, options, progress) {
    const size = sizeOf(job);
    const most = this.#farm.server?.limits.body_bytes;
    if (size > most) throw new Error(`The files have ${bytes(size)}. The limit of this server is ${bytes(most)}.`);
    const place = `${which} ${job.lead.file.name}`;
    if (!this.#keys.has(place)) this.#keys.set(place, freshKey());
    return submit({...this.#content(job), options, key: this.#keys.get(place), progress});
  }

  /** Returns the files as parts of a form. A particle file with a topology takes the part of the scene. */
  #content = ({lead, parts}) => {
    const first = lead.scene || parts.length > 0;
    return {scene: first ? lead.file : undefined, files: (first ? parts : [lead]).map(({file}) => file)};
  };

  async #planOf(job, signal) {
    if (!this.#plans.has(job.lead)) {
      const plan = await submit({to: 'plan', ...this.#content(job), options: this.#options(job), signal});
      this.#plans.set(job.lead, plan);
    }
    return this.#plans.get(job.lead);
  }

  async #showForecast() {
    if (!this.form.reportValidity()) return;
    setText(this.forecast, 'estimating…');
    await this.#work(async () => {
      const jobs = this.#files.jobs();
      let text = '';
      try {
        for (const job of jobs) {
          const plan = await this.#planOf(job);
          text = forecastText(plan);
          setText(this.notes, (plan.notes ?? []).join(' '));
          if (jobs.length > 1) this.#status.set(job.lead, {text, kind: 'hint'});
        }
        if (jobs.length > 1) text = this.#sumText(jobs);
      } catch (problem) {
        text = '';
        this.#canForecast = problem.status !== 404 && problem.status !== 405;
        this.#showProblem(this.#canForecast ? problem.message : 'This coordinator makes no forecasts: it is older than this page.');
      }
      setText(this.forecast, text);
    });
  }

  #sumText(jobs) {
    const plans = jobs.map(job => this.#plans.get(job.lead));
    const seconds = plans.reduce((sum, plan) => sum + (plan?.seconds?.expected ?? 0), 0);
    return `${jobs.length} jobs: about ${roughly(seconds + Math.max(...plans.map(plan => plan?.queue_seconds ?? 0)))} in total`;
  }

  /** Returns the number of threads that may trace. */
  #threads() {
    let threads = 0;
    for (const worker of this.#farm.workers.values()) if (worker.state === 'ready') threads += worker.threads;
    return threads;
  }

  /** Forecasts jobs that may take long. Says so if they take more than an hour, and asks if they take a day or more. Returns
   *  whether to submit them. A forecast that fails or is late decides nothing. */
  async #mayTake(jobs) {
    const late = new AbortController();
    const timer = setTimeout(() => late.abort(), patience);
    const known = [];
    setText(this.forecast, 'estimating…');
    try {
      for (const job of jobs) {
        const long = mayTakeLong(this.#options(job), job.numbers, this.#threads());
        if (this.#canForecast && long && sizeOf(job) <= largestForecast) known.push([job, await this.#planOf(job, late.signal)]);
      }
    } catch (problem) {
      if (problem.status === 404 || problem.status === 405) this.#canForecast = false;
    }
    clearTimeout(timer);
    setText(this.forecast, '');
    const [job, longest] = known.reduce((most, one) => secondsOf(one[1]) > secondsOf(most[1]) ? one : most, []);
    const seconds = secondsOf(longest);
    if (seconds <= hour) return true;
    const text = `${nameOf(job)}: ${forecastText(longest)}`;
    setText(this.forecast, text);
    if (seconds >= day) return confirm(`This takes about ${roughly(seconds)}. Submit it?`, text, 'Keep editing', 'Submit anyway');
    notify(text);
    return true;
  }
}
