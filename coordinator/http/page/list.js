// A table of any number of rows. Only visible rows have elements.

import {el} from './dom.js';

const spare = 3;  // additional rows above and below the visible ones

export class VirtualTable {
  #make;
  #fill;
  #items = [];
  #rows = [];  // elements; row i of the table is in #rows[i % #rows.length]
  #current = 0;  // the row that gets the focus with Tab
  #rowHeight = 0;

  /** `columns`: [{name, title, sort}]; `title` may be an element. `make(row)` adds a cell for each column and
   *  returns `parts` for fill(parts, item). The first link or button of a row gets the row's focus.
   *  `nearEnd()` is called when the last rows are visible. */
  constructor({label, kind, columns, make, fill, nearEnd}) {
    this.#make = make;
    this.#fill = fill;
    this.nearEnd = nearEnd;
    this.head = el('div', {class: 'row head', role: 'row', 'aria-rowindex': 1}, ...columns.map(({name, title}) =>
      el('div', {class: name, role: 'columnheader'}, title)));
    this.body = el('div', {class: 'rows', role: 'rowgroup'});
    this.scroller = el('div', {class: 'scroller', tabindex: 0, role: 'table', 'aria-label': label},
      el('div', {role: 'rowgroup', class: 'heads'}, this.head), this.body);
    this.element = el('div', {class: `table ${kind}`}, this.scroller);
    this.scroller.addEventListener('scroll', () => this.draw(), {passive: true});
    this.scroller.addEventListener('keydown', event => this.#key(event));
    new ResizeObserver(() => this.#resize()).observe(this.scroller);
  }

  get items() {
    return this.#items;
  }

  set(items) {
    this.#items = items;
    this.scroller.setAttribute('aria-rowcount', items.length + 1);
    this.body.style.height = items.length * this.#rowHeight + 'px';
    this.draw(true);
  }

  /** Draws the visible rows. `again`: also draws rows whose position has not changed. */
  draw(again = false) {
    if (!this.#rowHeight) return;
    const view = this.scroller.clientHeight;
    const first = Math.max(0, Math.floor(this.scroller.scrollTop / this.#rowHeight) - spare);
    this.#addRows(Math.ceil(view / this.#rowHeight) + 2 * spare + 1);
    const end = Math.min(this.#items.length, first + this.#rows.length);
    for (let index = first; index < first + this.#rows.length; ++index) {
      const row = this.#rows[index % this.#rows.length];
      if (index >= end) {
        row.element.hidden = true;
        row.index = -1;
      } else if (again || row.index !== index) {
        this.#showRow(row, index);
      }
    }
    if (end >= this.#items.length - spare) this.nearEnd?.();
  }

  #showRow(row, index) {
    if (row.index !== index) {
      // The focus must not move to another row.
      if (row.element.contains(document.activeElement)) this.scroller.focus({preventScroll: true});
      row.index = index;
      row.element.hidden = false;
      row.element.style.transform = `translateY(${index * this.#rowHeight}px)`;
      row.element.setAttribute('aria-rowindex', index + 2);
      row.element.classList.toggle('odd', index % 2 === 1);
      this.#setTabStop(row);
    }
    this.#fill(row.parts, this.#items[index], row.element);
  }

  #setTabStop(row) {
    for (const target of row.targets) target.tabIndex = row.index === this.#current ? 0 : -1;
  }

  #addRows(count) {
    if (this.#rows.length >= count) return;
    while (this.#rows.length < count) {
      const element = el('div', {class: 'row', role: 'row', hidden: true});
      const parts = this.#make(element);
      const row = {element, parts, index: -1, targets: [...element.querySelectorAll('a, button')]};
      element.addEventListener('focusin', () => this.#setCurrent(row.index));
      this.#rows.push(row);
      this.body.append(element);
    }
    for (const row of this.#rows) row.index = -1;  // their positions depend on the number of elements
  }

  #setCurrent(index) {
    this.#current = index;
    for (const row of this.#rows) this.#setTabStop(row);
  }

  #key(event) {
    const page = Math.max(1, Math.floor(this.scroller.clientHeight / this.#rowHeight) - 1);
    const step = {ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity}[event.key];
    if (step === undefined || !this.#items.length || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const inside = this.body.contains(document.activeElement);
    const from = inside ? this.#current : Math.round(this.scroller.scrollTop / this.#rowHeight) - Math.sign(step);
    const to = Math.min(this.#items.length - 1, Math.max(0, from + step));
    this.#reveal(to);
    this.#setCurrent(to);
    this.#rows.find(row => row.index === to)?.targets[0]?.focus({preventScroll: true});
  }

  #reveal(index) {
    const top = index * this.#rowHeight;
    const view = this.scroller.clientHeight - this.head.offsetHeight;
    if (top < this.scroller.scrollTop) this.scroller.scrollTop = top;
    else if (top + this.#rowHeight > this.scroller.scrollTop + view) {
      this.scroller.scrollTop = top + this.#rowHeight - view;
    }
    this.draw();
  }

  /** Reads the height of a row from the style sheet: it differs on a phone. */
  #resize() {
    const height = parseFloat(getComputedStyle(this.scroller).getPropertyValue('--row'));
    if (height && height !== this.#rowHeight) {
      this.#rowHeight = height;
      for (const row of this.#rows) row.index = -1;
    }
    this.set(this.#items);
  }
}
