// Signing in and out. Without a token that the server accepts, the page shows nothing of the farm.

import {token} from './api.js';
import {ask, button, el, setText} from './dom.js';

const places = 'An administrator of the farm makes tokens with';
const command = 'parray keygen DIR --token NAME';

export class SignInView {
  title = 'Sign in';
  #farm;
  #asking = false;

  constructor(farm) {
    this.#farm = farm;
    this.why = el('p', {});
    this.element = el('section', {class: 'view sign-in', 'aria-labelledby': 'sign-in-title'},
      el('div', {class: 'empty'}, el('h1', {id: 'sign-in-title', tabindex: -1}, 'You are not signed in'), this.why,
        el('p', {}, places), el('pre', {}, command), button('Sign in', () => this.ask(), {class: 'primary'})));
  }

  show() {
    this.update();
    this.ask();
  }

  update() {
    setText(this.why, token.get() ? `The server refused the token: ${this.#farm.connection.text}.` : 'This farm requires a token.');
  }

  /** Asks for the token in a dialog. */
  async ask() {
    if (this.#asking) return;
    this.#asking = true;
    const refused = token.get() && this.#farm.connection.text;
    const field = el('input', {type: 'password', name: 'token', required: true, autocomplete: 'off', spellcheck: 'false', 'aria-label': 'Token', autofocus: true});
    const keep = el('input', {type: 'checkbox', name: 'keep'});
    const given = await ask('Token', close => [
      el('form', {method: 'dialog', onsubmit: event => {
        event.preventDefault();
        close(field.value.trim());
      }}, el('h2', {}, 'This farm requires a token'), refused ? el('p', {class: 'trouble'}, refused) : '',
      field, el('label', {class: 'check'}, keep, 'Keep the token on this machine'),
      el('p', {class: 'hint'}, `${places} ${command}. Unless you keep it, this tab forgets the token when you close it.`),
      el('div', {class: 'answers'}, button('Cancel', () => close()), el('button', {type: 'submit', class: 'primary'}, 'Sign in')))]);
    this.#asking = false;
    if (!given) return;
    token.set(given, keep.checked);
    this.#farm.wake();
  }
}

/** Forgets the token and everything that the page knows: it loads the page again. */
export function signOut() {
  token.forget();
  sessionStorage.removeItem('parray-quick-looks');
  location.reload();
}

/** Signs out when another tab of this browser does, if the token is kept on this machine. */
export function followOtherTabs() {
  addEventListener('storage', event => {
    if (event.key === token.place && event.oldValue && !event.newValue) signOut();
  });
}
