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
  #keyOf;

  /** `columns`: [{name, title, sort}]; `title` may be an element. `make(row)` adds a cell for each column and
   *  returns `parts` for fill(parts, item). The first link of a row, or else its first control, gets the
   *  row's focus. `keyOf(item)` identifies an item when the items change. `nearEnd()` is called when the last rows
   *  are visible, `pressed(event, index)` for keys in a row that the table does not use itself, and
   *  `moved(from, to)` when Shift and an arrow key move the focus. */
  constructor({label, kind, columns, make, fill, keyOf = item => item, nearEnd, pressed, moved}) {
    this.#make = make;
    this.#fill = fill;
    this.#keyOf = keyOf;
    this.nearEnd = nearEnd;
    this.pressed = pressed;
    this.moved = moved;
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

  /** Replaces the items. The focus, and the first visible item unless it is the first of all, stay in place. */
  set(items) {
    const place = this.#rowHeight ? this.place : {};
    this.#items = items;
    this.scroller.setAttribute('aria-rowcount', items.length + 1);
    this.body.style.height = items.length * this.#rowHeight + 'px';
    this.#follow(place);
    this.draw(true);
    if (place.focused) this.#focusAgain(place.focus);
  }

  /** Where the list is: {top: key of the first visible item, or undefined at the top, offset: pixels of it that are
   *  above the view, focus: key of the current item, focused: the focus is in a row}. */
  get place() {
    const {scrollTop} = this.scroller;
    const first = Math.floor(scrollTop / this.#rowHeight);
    const key = index => index in this.#items ? this.#keyOf(this.#items[index]) : undefined;
    return {top: scrollTop > 0 ? key(first) : undefined, offset: scrollTop - first * this.#rowHeight,
      focus: key(this.#current), focused: this.body.contains(document.activeElement)};
  }

  /** Scrolls to a place and, if it had the focus, focuses its row again. Returns whether a row has the focus. */
  restore(place) {
    this.#follow(place);
    this.draw(true);
    return Boolean(place.focused) && this.#focusAgain(place.focus);
  }

  #indexOf(key, near) {
    if (near in this.#items && this.#keyOf(this.#items[near]) === key) return near;
    return this.#items.findIndex(item => this.#keyOf(item) === key);
  }

  #follow({top, offset, focus}) {
    if (top !== undefined) {
      const first = this.#indexOf(top, Math.floor(this.scroller.scrollTop / this.#rowHeight));
      const wanted = first * this.#rowHeight + offset;
      if (first >= 0 && Math.abs(wanted - this.scroller.scrollTop) > 0.5) this.scroller.scrollTop = wanted;
    }
    if (focus !== undefined) {
      const index = this.#indexOf(focus, this.#current);
      if (index >= 0 && index !== this.#current) this.#setCurrent(index);
    }
  }

  /** Focuses the current row if it is the row of `key`. A row that moved to another element has lost the focus. */
  #focusAgain(key) {
    const row = this.#rows.find(({index}) => index === this.#current);
    if (!row || this.#keyOf(this.#items[row.index]) !== key) return false;
    if (!row.element.contains(document.activeElement)) row.main?.focus({preventScroll: true});
    return true;
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
      const row = {element, parts, index: -1, targets: [...element.querySelectorAll('a, button, input')]};
      row.main = row.targets.find(target => target.tagName === 'A') ?? row.targets[0];
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
    if (!this.#items.length || event.ctrlKey || event.altKey || event.metaKey) return;
    const inside = this.body.contains(document.activeElement);
    if (step === undefined) {
      if (inside) this.pressed?.(event, this.#current);
      return;
    }
    event.preventDefault();
    const from = inside ? this.#current : Math.round(this.scroller.scrollTop / this.#rowHeight) - Math.sign(step);
    const to = Math.min(this.#items.length - 1, Math.max(0, from + step));
    this.#reveal(to);
    this.#setCurrent(to);
    this.#rows.find(row => row.index === to)?.main?.focus({preventScroll: true});
    if (inside && event.shiftKey) this.moved?.(from, to);
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
