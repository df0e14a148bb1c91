// The page: selects the view, and handles header, keys, themes and tokens.

import {token} from './api.js';
import {ask, button, el, setClass, setText} from './dom.js';
import {Farm} from './farm.js';
import {count} from './format.js';
import {JobView} from './job.js';
import {JobsView} from './jobs.js';
import {SubmitView} from './submit.js';
import {WorkersView} from './workers.js';

const place = id => document.getElementById(id);
const farm = new Farm();
const views = {jobs: new JobsView(farm), job: new JobView(farm), workers: new WorkersView(farm), submit: new SubmitView(farm)};
let view;

/** Shows the view that the URL selects: "#/jobs/12". */
function showView() {
  const [, name, id] = location.hash.match(/^#\/([a-z]+)(?:\/(\d+))?$/) ?? [undefined, 'jobs'];
  const next = name === 'jobs' && id ? views.job : views[name] ?? views.jobs;
  const first = !view;
  view?.hide?.();
  view = next;
  place('main').replaceChildren(view.element);
  view.show(Number(id));
  for (const link of document.querySelectorAll('nav a')) {
    if (link.dataset.view === name) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  showTitle();
  if (!first) view.element.querySelector('h1').focus({preventScroll: true});
}

function showTitle() {
  const title = `${view.title} · ParRay`;
  if (document.title !== title) document.title = title;
}

function showHeader() {
  const {running, waiting, speed, workers} = farm.summary();
  const {state, text} = farm.connection;
  setText(place('summary'), farm.generation ?
    [`${running} running`, `${waiting} queued`, `${workers} ${workers === 1 ? 'worker' : 'workers'}`, running && speed > 0 && count(speed) + ' samples/s']
      .filter(Boolean).join('  ·  ') : '');
  setText(place('connection'), state === 'token' ? 'sign-in required' : text || state);
  setClass(place('connection'), 'connection ' + state);
  const account = place('account');
  account.hidden = !token.get() && state !== 'token';
  setText(account, state === 'token' ? 'Sign in' : farm.server?.user ? `Sign out ${farm.server.user}` : 'Sign out');
}

let asking = false;
async function askForToken(why) {
  if (asking) return;
  asking = true;
  const field = el('input', {type: 'password', name: 'token', required: true, autocomplete: 'off', spellcheck: 'false', 'aria-label': 'Token', autofocus: true});
  const given = await ask('Token', close => [
    el('form', {method: 'dialog', onsubmit: event => {
      event.preventDefault();
      close(field.value.trim());
    }}, el('h2', {}, 'This farm requires a token'),
    el('p', {class: token.get() ? 'trouble' : ''}, token.get() ? why : 'The administrator makes tokens with parray keygen DIR --token NAME. This tab keeps the token until you close it.'),
    field, el('div', {class: 'answers'}, el('button', {type: 'submit', class: 'primary'}, 'Sign in')))]);
  asking = false;
  if (!given) return;
  token.set(given);
  farm.wake();
}

const themes = ['system', 'light', 'dark'];
function showTheme() {
  const chosen = localStorage.getItem('parray-theme');
  if (chosen) document.documentElement.dataset.theme = chosen;
  else delete document.documentElement.dataset.theme;
  setText(place('theme'), {light: '☀', dark: '☾'}[chosen] ?? '◐');
  const label = `Theme: ${chosen ?? themes[0]}`;
  place('theme').setAttribute('aria-label', label);
  place('theme').title = label;
}

function nextTheme() {
  const now = localStorage.getItem('parray-theme') ?? themes[0];
  const next = themes[(themes.indexOf(now) + 1) % themes.length];
  if (next === themes[0]) localStorage.removeItem('parray-theme');
  else localStorage.setItem('parray-theme', next);
  showTheme();
}

const to = hash => () => { location.hash = hash; };
const keys = {  // [description, action]
  j: ['show jobs', to('#/jobs')], w: ['show workers', to('#/workers')], n: ['submit a new scene', to('#/submit')],
  p: ['pause or resume this job', () => view === views.job && view.pauseOrResume()],
  t: ['change the theme: system, light, dark', nextTheme], '?': ['show this help', () => showHelp()]};
const otherKeys = [['↑ ↓ Page Home End', 'in a list: move between rows; Enter opens a row'], ['+ −', 'in a picture: zoom'],
  ['0', 'in a picture: fit to the window'], ['1', 'in a picture: show pixels at their real size'],
  ['← → ↑ ↓', 'in a picture: move to another pixel; with Shift by ten pixels'], ['[ ]', 'in a picture: change the exposure'],
  ['m', 'in a picture: show the next map (error, cost, workers)']];
const lettersOff = () => localStorage.getItem('parray-keys') === 'off';

function showHelp() {
  const row = (key, text) => [el('dt', {}, el('kbd', {}, key)), el('dd', {}, text)];
  const letters = el('input', {type: 'checkbox', checked: !lettersOff(), onchange: event =>
    event.target.checked ? localStorage.removeItem('parray-keys') : localStorage.setItem('parray-keys', 'off')});
  return ask('Help', close => [
    el('h2', {}, 'Keyboard shortcuts'),
    el('dl', {class: 'keys'}, ...Object.entries(keys).flatMap(([key, [text]]) => row(key, text)),
      ...otherKeys.flatMap(([key, text]) => row(key, text))),
    el('label', {class: 'check'}, letters, 'Enable keyboard shortcuts'),
    el('p', {}, 'In a picture, zoom with the wheel or two fingers, drag to move, and double-click to zoom in and out. ',
      el('a', {href: 'api'}, 'API'), ` of this server${farm.server ? ', ParRay ' + farm.server.version : ''}.`),
    el('div', {class: 'answers'}, button('Close', () => close(), {autofocus: true}))]);
}

document.addEventListener('keydown', event => {
  const typing = event.target.closest('input:not([type=radio], [type=checkbox], [type=range]), select, textarea, dialog');
  if (typing || event.ctrlKey || event.altKey || event.metaKey || lettersOff()) return;
  const key = keys[event.key];
  if (!key) return;
  event.preventDefault();
  key[1]();
});

function acceptDrops() {
  const hasFiles = event => event.dataTransfer?.types.includes('Files');
  let depth = 0;
  const mark = change => {
    depth = Math.max(0, depth + change);
    document.body.classList.toggle('dropping', depth > 0);
  };
  addEventListener('dragenter', event => hasFiles(event) && mark(1));
  addEventListener('dragleave', event => hasFiles(event) && mark(-1));
  addEventListener('dragover', event => hasFiles(event) && event.preventDefault());
  addEventListener('drop', event => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    mark(-depth);
    location.hash = '#/submit';
    views.submit.add(event.dataTransfer.files);
  });
}

place('theme').addEventListener('click', nextTheme);
place('help').addEventListener('click', showHelp);
place('account').addEventListener('click', () => {
  if (farm.connection.state === 'token') {
    askForToken(farm.connection.text);
    return;
  }
  token.forget();
  farm.wake();
});
addEventListener('hashchange', showView);
addEventListener('online', () => farm.wake());
farm.onChange(changes => {
  if (changes.connection && farm.connection.state === 'token') askForToken(farm.connection.text);
  view.update(changes);
  showHeader();
  showTitle();
});
acceptDrops();
showTheme();
showView();
showHeader();
farm.run();
