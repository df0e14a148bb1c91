// The view of one worker.

import {el} from './dom.js';

export class WorkerView {
  title = 'Worker';
  constructor() {
    this.element = el('section', {class: 'view worker', 'aria-labelledby': 'worker-title'},
      el('div', {class: 'bar-of-view'}, el('h1', {id: 'worker-title', tabindex: -1}, 'Worker')));
  }
  show() {}
  update() {}
}
