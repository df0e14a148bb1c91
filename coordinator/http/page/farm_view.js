// The view of the whole farm.

import {el} from './dom.js';

export class FarmView {
  title = 'Farm';
  constructor() {
    this.element = el('section', {class: 'view farm', 'aria-labelledby': 'farm-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'farm-title', tabindex: -1}, 'Farm')));
  }
  show() {}
  update() {}
}
