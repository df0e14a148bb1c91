// The view of all jobs: filters, search, order, choice of many jobs.

import {getJson} from './api.js';
import {BulkBar} from './bulk.js';
import {Choice} from './choice.js';
import {button, el, setText} from './dom.js';
import {counted, whole} from './format.js';
import {comparisonOf, filters, formatQuery, matcherOf, parseQuery, requestOf, sortedBy} from './job_query.js';
import {fillRow, headsOf, makeRow, showOrder} from './job_row.js';
import {VirtualTable} from './list.js';
import {RowPictures} from './row_pictures.js';

const typingPause = 200;  // ms after the last letter of a search
const sortAgainAfter = 1500;  // ms; the order by a value that changes all the time is not renewed more often
const renewAgesEvery = 15000;
const picturesOff = () => localStorage.getItem('parray-thumbnails') === 'off';

export class JobsView {
  title = 'Jobs';
  #farm;
  #query = parseQuery('');
  #loaded = new Set();  // numbers of the jobs that the server has sent for this query
  #last;  // the last of them, as the server sent it
  #next;  // where the next page begins: `before` or `offset`; null: there is none; undefined: nothing is loaded
  #total;  // jobs of the query, as the server counts them
  #shownTotal;  // without quick looks that are folded into their jobs; undefined: unknown
  #loading = false;
  #problem = '';
  #place;  // where the list was when another view came
  #quickLooks = new Map();  // number of a job: its quick look
  #timers = {};
  #pictures = new RowPictures();

  constructor(farm) {
    this.#farm = farm;
    this.choice = new Choice(() => this.table.items, () => this.#showChoice());
    this.all = el('input', {type: 'checkbox', 'aria-label': 'Choose all shown jobs', onclick: () => this.all.checked ? this.choice.all() : this.choice.clear()});
    this.table = new VirtualTable({label: 'Jobs', kind: 'jobs', columns: headsOf(el('label', {}, this.all), sort => this.#change(sortedBy(this.#query, sort))),
      make: row => makeRow(row, (event, job) => this.choice.toggle(job.id, event.shiftKey)), fill: (parts, job) => this.#fill(parts, job),
      keyOf: job => job.id, nearEnd: () => this.#load(), pressed: (event, index) => this.#pressed(event, index), moved: (from, to) => this.choice.extend(from, to)});
    this.bulk = new BulkBar(farm, {clear: () => this.#clearChoice(), all: () => this.#chooseAll()});
    this.#makeFilters();
    this.count = el('p', {class: 'count', role: 'status'});
    this.empty = el('div', {class: 'empty', hidden: true});
    this.element = el('section', {class: 'view list', 'aria-labelledby': 'jobs-title', onkeydown: event => this.#escape(event)},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'jobs-title', tabindex: -1}, 'Jobs'), this.states, this.search, this.user, this.mine, this.order, this.count, this.thumbnails),
      this.table.element, this.empty, this.bulk.element);
    this.#pictures.on = !picturesOff();
    this.#showPictures();
    this.#showFilters();
  }

  #makeFilters() {
    this.states = el('fieldset', {class: 'choice'}, el('legend', {class: 'unseen'}, 'Filter by state'),
      ...[...filters.keys()].map(name => el('label', {},
        el('input', {type: 'radio', name: 'filter', value: name, onchange: () => this.#change({state: name})}), el('span', {}, name))));
    this.search = el('input', {type: 'search', placeholder: 'Name or number', title: 'Search ( / )', 'aria-label': 'Search name or number', 'aria-keyshortcuts': '/',
      oninput: () => this.#change({q: this.search.value.trim()}, typingPause)});
    this.user = el('select', {'aria-label': 'User', onchange: () => this.#change({user: this.user.value}), onfocus: () => this.#loadUsers()});
    this.onlyMine = el('input', {type: 'checkbox', onchange: () => this.#change({mine: this.onlyMine.checked})});
    this.mine = el('label', {class: 'check'}, this.onlyMine, 'only mine');
    this.sort = el('select', {'aria-label': 'Sort by', onchange: () => this.#change({...sortedBy({}, this.sort.value)})},
      ...Object.entries({id: 'newest', name: 'scene', state: 'state', progress: 'progress', taken: 'time taken', finished: 'ended', user: 'user', priority: 'priority'})
        .map(([value, text]) => el('option', {value}, text)));
    this.order = el('label', {class: 'order'}, 'Sort', this.sort);
    this.withPictures = el('input', {type: 'checkbox', checked: !picturesOff(), onchange: () => this.#switchPictures()});
    this.thumbnails = el('label', {class: 'check thumbnails'}, this.withPictures, 'pictures');
  }

  /** `query`: the address after "?". Without it, a return from another view shows the list as it was. `again`: this
   *  view is shown already. Returns whether a row has the focus again. */
  show(_, query, again) {
    const back = !again && this.#place !== undefined && query === undefined;
    if (!back && formatQuery(parseQuery(query)) !== formatQuery(this.#query)) this.#set(parseQuery(query));
    this.#writeAddress();
    clearInterval(this.#timers.ages);
    this.#timers.ages = setInterval(() => this.table.draw(true), renewAgesEvery);
    this.#rebuild();
    const focused = this.#place && !again ? this.table.restore(this.#place) : false;
    this.#place = undefined;
    return focused;
  }

  hide() {
    this.#place = this.table.place;
    clearInterval(this.#timers.ages);
  }

  update(changes) {
    if (changes.generation) {
      this.#reset();
      this.#load();
    }
    if (changes.connection) this.#showFilters();
    if (changes.shape || changes.generation) this.#rebuild();
    else if (changes.jobs.size) {
      this.table.draw(true);
      if (this.#query.sort !== 'id') this.#timers.sort ??= setTimeout(() => this.#rebuild(), sortAgainAfter);
    }
  }

  #fill(parts, job) {
    fillRow(parts, job, {chosen: this.choice.has(job.id), quick: this.#quickLooks.get(job.id)});
    this.#pictures.show(parts.image, job);
  }

  get #user() {
    return this.#farm.server?.user;
  }

  /** Changes the query. `pause`: ms before the request to the server. The loaded jobs are filtered at once. */
  #change(values, pause = 0) {
    this.#set({...this.#query, ...values}, pause);
    this.#writeAddress();
    this.#rebuild();
  }

  #set(query, pause = 0) {
    this.#query = query;
    this.choice.clear();
    this.#showFilters();
    this.#reset();
    this.table.scroller.scrollTop = 0;
    clearTimeout(this.#timers.load);
    this.#timers.load = setTimeout(() => this.#load(), pause);
  }

  #writeAddress() {
    const text = formatQuery(this.#query);
    history.replaceState(null, '', '#/jobs' + (text ? '?' + text : ''));
  }

  #showFilters() {
    const {q, user, state, mine, sort} = this.#query;
    this.states.querySelector(`[value=${state}]`).checked = true;
    if (this.search.value.trim() !== q) this.search.value = q;
    this.onlyMine.checked = mine;
    this.mine.hidden = !this.#user;
    this.user.disabled = mine && Boolean(this.#user);
    this.sort.value = sort === 'submitted' ? 'id' : sort;
    this.#showUsers(user ? [user] : []);
    this.user.value = user;
    showOrder(this.table.head, this.#query);
  }

  /** Adds users to the choice. */
  #showUsers(names) {
    const known = new Set([...this.user.options].map(({value}) => value));
    const fresh = [...new Set(names)].filter(name => name && !known.has(name));
    if (!known.has('')) this.user.append(el('option', {value: ''}, 'all users'));
    if (fresh.length) {
      const all = [...known, ...fresh].filter(Boolean).sort();
      const {value} = this.user;
      this.user.replaceChildren(el('option', {value: ''}, 'all users'), ...all.map(name => el('option', {value: name}, name)));
      this.user.value = value;
    }
    this.user.hidden = this.user.options.length < 2;
  }

  async #loadUsers() {
    try {
      const {users = []} = await getJson('farm');
      this.#showUsers(users.map(({user}) => user));
    } catch {
      // The choice keeps the users of the loaded jobs.
    }
  }

  #reset() {
    this.#loaded.clear();
    this.#last = this.#next = this.#total = undefined;
    this.#problem = '';
  }

  /** Loads the next page, if there is one. */
  async #load() {
    if (this.#loading || this.#next === null || !this.#farm.generation) return;
    this.#loading = true;
    const query = this.#query;
    const generation = this.#farm.generation;
    const current = () => query === this.#query && generation === this.#farm.generation;
    try {
      const byId = query.sort === 'id' && query.order === 'desc';
      const {jobs, next, total} = await this.#farm.loadJobs({...requestOf(query, this.#user), ...this.#next !== undefined && {[byId ? 'before' : 'offset']: this.#next}});
      if (/^\d+$/.test(query.q) && !this.#farm.jobs.has(Number(query.q))) await this.#farm.loadJob(Number(query.q)).catch(() => {});
      if (current()) this.#take(jobs, next, total, byId);
    } catch (problem) {
      if (current()) {
        this.#problem = problem.message;
        this.#next = null;  // no further attempt until the next connection
      }
    }
    this.#loading = false;
    if (!current()) this.#load();
    else this.#rebuild();
  }

  #take(jobs, next, total, byId) {
    for (const {id} of jobs) this.#loaded.add(id);
    if (jobs.length) this.#last = {...jobs.at(-1)};
    this.#total = total;
    const reached = (this.#next ?? 0) + jobs.length;
    this.#next = byId ? next ?? null : jobs.length && reached < total ? reached : null;
  }

  #rebuild() {
    clearTimeout(this.#timers.sort);
    this.#timers.sort = undefined;
    const compare = comparisonOf(this.#query);
    const matches = matcherOf(this.#query, this.#user);
    const reached = job => this.#next === null || !this.#last || this.#loaded.has(job.id) || compare(job, this.#last) <= 0;
    const users = new Set();
    this.#quickLooks.clear();
    const jobs = [];
    let folded = 0;
    for (const job of this.#farm.jobs.values()) {
      users.add(job.user);
      const of = this.#farm.jobs.get(job.preview_of);
      if (of) this.#quickLooks.set(of.id, job);
      if (of && matches(job)) ++folded;
      if (!of && matches(job) && reached(job)) jobs.push(job);
    }
    jobs.sort(compare);
    this.table.set(jobs);
    this.choice.prune();
    this.#showUsers(users);
    this.#showCount(jobs.length, folded);
    this.#showChoice(false);
    this.#showEmpty(jobs.length === 0 && this.#next === null);
  }

  get #whole() {
    return this.#next === null && !this.#problem;
  }

  #showCount(shown, folded) {
    const all = this.#whole ? shown : this.#total === undefined ? undefined : Math.max(shown, this.#total - folded);
    this.#shownTotal = all;
    setText(this.count, all !== undefined ? counted(all, 'job') : shown ? `${whole(shown)}+ jobs` : '');
  }

  #showChoice(draw = true) {
    const {jobs} = this.choice;
    const shown = this.table.items.length;
    this.all.checked = shown > 0 && jobs.length === shown;
    this.all.indeterminate = jobs.length > 0 && jobs.length < shown;
    this.bulk.show(jobs, jobs.length === shown && !this.#whole ? this.#shownTotal : undefined);
    if (draw) this.table.draw(true);
  }

  #clearChoice() {
    this.choice.clear();
    this.table.scroller.focus({preventScroll: true});
  }

  /** Loads all jobs of the query, then chooses them. */
  async #chooseAll() {
    const query = this.#query;
    while (query === this.#query && this.#next !== null) {
      await this.#load();
      await new Promise(resolve => setTimeout(resolve, this.#loading ? 50 : 0));
    }
    if (query === this.#query) this.choice.all();
  }

  #pressed(event, index) {
    if (event.key !== ' ' && event.key !== 'x' || event.target.tagName === 'INPUT' && event.key === ' ') return;
    event.preventDefault();
    this.choice.toggle(this.table.items[index].id);
  }

  #escape(event) {
    if (event.key === 'Escape' && this.choice.size && event.target !== this.search) this.#clearChoice();
  }

  #switchPictures() {
    this.#pictures.on = this.withPictures.checked;
    if (this.#pictures.on) localStorage.removeItem('parray-thumbnails');
    else localStorage.setItem('parray-thumbnails', 'off');
    this.#showPictures();
    this.table.draw(true);
  }

  #showPictures() {
    this.table.element.classList.toggle('with-pictures', this.#pictures.on);
  }

  #showEmpty(empty) {
    this.empty.hidden = !empty;
    this.table.element.hidden = empty;
    if (!empty) return;
    const all = formatQuery({...this.#query, sort: 'id', order: 'desc'}) === '';
    this.empty.replaceChildren(el('p', {}, this.#problem || (all ? 'No jobs yet.' : 'No job matches these filters.')));
    if (this.#problem) return;
    if (all) {
      this.empty.append(el('p', {}, 'Drop a scene or a particle file anywhere on this page, choose one under ', el('a', {href: '#/submit'}, 'Submit'), ', or run'),
        el('pre', {}, 'parray submit SCENE'));
    } else {
      this.empty.append(button('Show all jobs', () => this.#change(parseQuery(''))));
    }
  }
}
