// Drains and resumes workers, after a question.

import {change} from './api.js';
import {confirm, el, notify} from './dom.js';

export const maySteer = farm => farm.server?.role !== 'client';

/** Asks, and then drains a worker that is ready, or resumes another one. */
export async function steerWorker(farm, worker) {
  const drain = worker.state === 'ready';
  const host = el('input', {type: 'checkbox'});
  const yes = await confirm(`${drain ? 'Drain' : 'Resume'} ${worker.name}?`, drain ?
    'It finishes its leases and gets no more.' : 'It gets leases again.', 'Cancel', drain ? 'Drain' : 'Resume',
  el('label', {class: 'check'}, host, `Apply to all workers of host ${worker.host}`));
  if (!yes) return;
  const name = host.checked ? worker.host : worker.name;
  try {
    const query = host.checked ? '?host=true' : '';
    const {workers} = await change('POST', `workers/${encodeURIComponent(name)}/${drain ? 'drain' : 'readmit'}${query}`);
    for (const changed of workers) farm.updateWorker(changed);
    notify(`${name} ${drain ? 'gets no more leases' : 'gets leases again'}`);
  } catch (problem) {
    notify(problem.message, 'error');
  }
}
