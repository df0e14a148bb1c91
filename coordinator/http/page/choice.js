// The jobs that are chosen in a list by checkboxes, Shift-click and keys.

export class Choice {
  #chosen = new Set();  // numbers of jobs
  #anchor;  // number of the job where a range begins
  #items;
  #changed;

  /** `items()`: the shown jobs in their order. `changed()`: called after each change. */
  constructor(items, changed) {
    this.#items = items;
    this.#changed = changed;
  }

  has(id) {
    return this.#chosen.has(id);
  }

  get size() {
    return this.#chosen.size;
  }

  get jobs() {
    return this.#chosen.size ? this.#items().filter(({id}) => this.#chosen.has(id)) : [];
  }

  /** Chooses a job or undoes it. `range`: does the same with all jobs from the last toggled one on. */
  toggle(id, range = false) {
    const on = !this.#chosen.has(id);
    const ids = this.#items().map(job => job.id);
    const [from, to] = [ids.indexOf(this.#anchor), ids.indexOf(id)].sort((a, b) => a - b);
    for (const one of range && from >= 0 ? ids.slice(from, to + 1) : [id]) this.#chosen[on ? 'add' : 'delete'](one);
    this.#anchor = id;
    this.#changed();
  }

  /** Chooses the jobs at two indexes. */
  extend(from, to) {
    const items = this.#items();
    this.#chosen.add(items[from].id).add(items[to].id);
    this.#anchor = items[to].id;
    this.#changed();
  }

  all() {
    for (const {id} of this.#items()) this.#chosen.add(id);
    this.#changed();
  }

  clear() {
    this.#chosen.clear();
    this.#anchor = undefined;
    this.#changed();
  }

  /** Forgets jobs that are no longer shown, so that no action hits a hidden job. */
  prune() {
    if (!this.#chosen.size) return;
    const shown = new Set(this.#items().map(job => job.id));
    for (const id of this.#chosen) if (!shown.has(id)) this.#chosen.delete(id);
  }
}
