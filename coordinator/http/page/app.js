// The page: selects the view, and handles header, keys, themes and tokens.

import {token} from './api.js';
import {setAttribute, setClass, setText} from './dom.js';
import {Farm} from './farm.js';
import {FarmView} from './farm_view.js';
import {count, counted} from './format.js';
import {lettersOff, showHelp} from './help.js';
import {JobView} from './job.js';
import {JobsView} from './jobs.js';
import {noticeEnded} from './notices.js';
import {followOtherTabs, SignInView, signOut} from './sign_in.js';
import {SubmitView} from './submit.js';
import {WorkerView} from './worker.js';
import {WorkersView} from './workers.js';

const place = id => document.getElementById(id);
const farm = new Farm();
const views = {jobs: new JobsView(farm), job: new JobView(farm), farm: new FarmView(farm),
  workers: new WorkersView(farm), worker: new WorkerView(farm), submit: new SubmitView(farm)};
const signIn = new SignInView(farm);
const signedOut = () => farm.connection.state === 'token';
let view;

/** Shows the view that the URL selects: "#/jobs/12", "#/workers/NAME", "#/jobs?state=failed". */
function showView() {
  const [, name, id, query] = location.hash.match(/^#\/([a-z]+)(?:\/([^?]+))?(?:\?(.*))?$/) ?? [undefined, 'jobs'];
  const single = {jobs: views.job, workers: views.worker}[name];
  const next = signedOut() ? signIn : id && single ? single : views[name] ?? views.jobs;
  const first = !view;
  const again = view === next;
  view?.hide?.();
  view = next;
  if (!again) place('main').replaceChildren(view.element);
  const focused = view.show(Number(id), query, again);
  for (const link of document.querySelectorAll('nav a')) setAttribute(link, 'aria-current', link.dataset.view === name ? 'page' : undefined);
  document.body.classList.toggle('signed-out', signedOut());
  showTitle();
  showBanner();
  if (!first && focused !== true) view.element.querySelector('h1').focus({preventScroll: true});
}

function showTitle() {
  const title = `${view.title} · ParRay`;
  if (document.title !== title) document.title = title;
}

function showHeader() {
  const {running, waiting, speed, workers} = farm.summary();
  const {state, text} = farm.connection;
  setText(place('summary'), farm.generation ?
    [`${running} running`, `${waiting} queued`, counted(workers, 'worker'), running && speed > 0 && count(speed) + ' samples/s']
      .filter(Boolean).join('  ·  ') : '');
  setText(place('connection'), state === 'token' ? 'sign-in required' : text || state);
  setClass(place('connection'), 'connection ' + state);
  const account = place('account');
  account.hidden = !token.get() && state !== 'token';
  setText(account, state === 'token' ? 'Sign in' : farm.server?.user ? `Sign out ${farm.server.user}` : 'Sign out');
}

const noticeAfter = 2000;  // ms; workers come after the connection
let withoutWorkers;  // timer, or true when the banner is due

/** Shows across the page that no workers are connected. */
function showBanner() {
  const none = farm.generation > 0 && farm.workers.size === 0 && ['live', 'polling'].includes(farm.connection.state);
  if (!none) {
    clearTimeout(withoutWorkers);
    withoutWorkers = undefined;
  } else {
    withoutWorkers ??= setTimeout(() => {
      withoutWorkers = true;
      showBanner();
    }, noticeAfter);
  }
  place('banner').hidden = withoutWorkers !== true || view === views.workers || view === views.farm;
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
  j: ['show jobs', to('#/jobs')], f: ['show the farm', to('#/farm')], w: ['show workers', to('#/workers')], n: ['submit a new scene', to('#/submit')],
  p: ['pause or resume this job', () => view === views.job && view.pauseOrResume()],
  t: ['change the theme: system, light, dark', nextTheme], '?': ['show this help', () => help()]};
const help = () => showHelp(Object.entries(keys).map(([key, [text]]) => [key, text]), farm.server);

document.addEventListener('keydown', event => {
  const typing = event.target.closest('input:not([type=radio], [type=checkbox], [type=range]), select, textarea, dialog');
  if (typing || event.ctrlKey || event.altKey || event.metaKey || lettersOff()) return;
  const search = event.key === '/' && view.search;
  const key = search ? undefined : keys[event.key];
  if (search || key || view.key?.(event)) event.preventDefault();
  if (search) {
    search.focus();
    search.select();
  }
  key?.[1]();
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
place('help').addEventListener('click', help);
place('account').addEventListener('click', () => signedOut() ? signIn.ask() : signOut());
addEventListener('hashchange', showView);
addEventListener('online', () => farm.wake());
farm.onChange(changes => {
  if (changes.connection && signedOut() !== (view === signIn)) showView();
  else if (changes.connection && signedOut()) signIn.ask();
  view.update(changes);
  noticeEnded(changes.ended, farm.server?.user);
  showHeader();
  showTitle();
  showBanner();
});
followOtherTabs();
acceptDrops();
showTheme();
showView();
showHeader();
farm.run();
