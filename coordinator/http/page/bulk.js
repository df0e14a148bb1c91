// Actions for many jobs at once: the bar below the list, one question, one request for up to 500 jobs, and a summary
// of what the server refused.

import {change} from './api.js';
import {ask, button, el, notify, setText} from './dom.js';
import {counted, whole} from './format.js';
import {mayControl, permits} from './job_rules.js';

const mostIds = 500;  // of one request
const words = {  // [label, the server's word, text for jobs that have been changed, text of the question]
  pause: ['Pause', 'pause', 'paused'], resume: ['Resume', 'resume', 'resumed'],
  priority: ['Priority', 'priority', 'changed', 'Among the jobs of one user, those of higher priority begin first.'],
  requeue: ['Requeue', 'requeue', 'queued again', 'They return to the queue and continue from their stored samples.'],
  cancel: ['Cancel', 'cancel', 'cancelled', 'Their workers stop. The samples are kept, and you can requeue the jobs.'],
  delete: ['Delete', 'forget', 'deleted', 'The server deletes the jobs and their pictures. This cannot be undone.']};
const risky = ['cancel', 'delete'];

/** Sends the requests until one fails. Returns the results of the jobs. `priority`: only for the word "priority". */
async function send(word, ids, priority) {
  const results = [];
  try {
    for (let begin = 0; begin < ids.length; begin += mostIds) {
      results.push(...(await change('POST', 'jobs/' + words[word][1], {ids: ids.slice(begin, begin + mostIds), priority})).results);
    }
  } catch (problem) {
    return {results, failure: problem.message};
  }
  return {results};
}

/** Returns the texts of refusals: [text, ids], the most frequent first. The number of a job in a text is left out. */
function groupsOf(refused) {
  const groups = new Map();
  for (const {id, problem} of refused) {
    const detail = (problem.detail ?? `status ${problem.status}`).replaceAll(new RegExp(`\\bjob ${id}\\b`, 'g'), 'the job');
    const text = detail[0].toUpperCase() + detail.slice(1);
    groups.set(text, [...groups.get(text) ?? [], id]);
  }
  return [...groups].sort(([, a], [, b]) => b.length - a.length);
}

const some = ids => ids.slice(0, 12).join(', ') + (ids.length > 12 ? ` and ${whole(ids.length - 12)} more` : '');

function showRefusals(done, refused) {
  const title = `${counted(refused.length, 'job')} refused`;
  return ask(title, close => [el('h2', {}, title), el('p', {}, done),
    el('ul', {class: 'refusals'}, ...groupsOf(refused).map(([text, ids]) => el('li', {}, el('p', {}, text), el('p', {class: 'hint'}, `${ids.length === 1 ? 'Job' : 'Jobs'} ${some(ids)}`)))),
    el('div', {class: 'answers'}, button('Close', () => close(), {autofocus: true}))]);
}

export class BulkBar {
  #farm;
  #jobs = [];  // the chosen ones
  #busy = false;

  /** `clear()`: chooses no job. `all()`: chooses all jobs of the list. */
  constructor(farm, {clear, all}) {
    this.#farm = farm;
    this.text = el('span', {role: 'status'});
    this.more = button('', all, {class: 'quiet more', hidden: true});
    this.buttons = Object.fromEntries(Object.keys(words).map(word => [word, button('', () => this.#act(word), {class: risky.includes(word) ? 'danger' : undefined})]));
    this.element = el('div', {class: 'bulk', role: 'group', 'aria-label': 'Actions for the chosen jobs', hidden: true},
      this.text, this.more, ...Object.values(this.buttons), button('Clear', clear, {class: 'quiet', title: 'Choose no job (Escape)'}));
  }

  /** Shows the actions for the chosen jobs. `total`: jobs of the list, if not all of them are loaded. */
  show(jobs, total) {
    this.#jobs = jobs;
    this.element.hidden = !jobs.length;
    if (!jobs.length) return;
    setText(this.text, `${whole(jobs.length)} chosen`);
    this.more.hidden = !(total > jobs.length);
    if (total > jobs.length) setText(this.more, `Choose all ${whole(total)}`);
    for (const [word, node] of Object.entries(this.buttons)) {
      const number = this.#idsFor(word).length;
      setText(node, words[word][0] + (number && number < jobs.length ? ` ${whole(number)}` : ''));
      node.disabled = this.#busy || !number;
    }
  }

  #idsFor(word) {
    return this.#jobs.filter(job => permits(job, word) && mayControl(job, this.#farm.server)).map(job => job.id);
  }

  async #question(word, number) {
    const [label, , , detail] = words[word];
    if (!detail) return {};
    const jobs = counted(number, 'job');
    const title = word === 'priority' ? `Priority of ${jobs}` : `${label} ${jobs}?`;
    const field = word === 'priority' ? el('input', {type: 'number', min: 0, max: 100, required: true, value: 50, autofocus: true, 'aria-label': 'Priority, 0 to 100'}) : '';
    return ask(title, close => [el('form', {method: 'dialog', onsubmit: event => {
      event.preventDefault();
      close({priority: field ? field.valueAsNumber : undefined});
    }}, el('h2', {}, title), el('p', {}, detail), field, el('div', {class: 'answers'},
      button(risky.includes(word) ? 'Keep jobs' : 'Back', () => close(), {autofocus: !field}),
      el('button', {type: 'submit', class: risky.includes(word) ? 'danger' : 'primary'}, word === 'priority' ? 'Set' : `${label} ${jobs}`)))]);
  }

  async #act(word) {
    const ids = this.#idsFor(word);
    const answer = await this.#question(word, ids.length);
    if (!answer) return;
    this.#setBusy(true);
    const {results, failure} = await send(word, ids, answer.priority);
    for (const {id, job, problem} of results) {
      if (problem) continue;
      if (word === 'delete') this.#farm.removeJob(id);
      else if (job) this.#farm.updateJob(job);
    }
    const refused = results.filter(({problem}) => problem);
    const number = results.length - refused.length;
    const done = number ? `${counted(number, 'job')} ${words[word][2]}${word === 'priority' ? ` to priority ${answer.priority}` : ''}.` : `No job ${words[word][2]}.`;
    if (failure) notify(`${failure}. ${done}`, 'error');
    if (refused.length) await showRefusals(done, refused);
    else if (!failure) notify(done);
    this.#setBusy(false);
  }

  #setBusy(busy) {
    this.#busy = busy;
    this.show(this.#jobs);
  }
}
