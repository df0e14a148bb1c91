// Which jobs the list shows, in which order: the query in the address "#/jobs?state=failed&user=ann", the request
// to the server, and the same filter and order for jobs that the page has loaded.

export const filters = new Map([
  ['all', []], ['active', ['queued', 'running', 'paused', 'finishing']], ['running', ['running', 'finishing']],
  ['queued', ['queued']], ['paused', ['paused']], ['done', ['done']], ['failed', ['failed']],
  ['cancelled', ['cancelled']]]);

const lower = text => (text ?? '').toLowerCase();

export const sorts = {  // name of the server's order: {of: key of a job, down: sorts from high to low first}
  id: {of: job => job.id, down: true}, name: {of: job => lower(job.name)}, user: {of: job => job.user ?? ''},
  state: {of: job => job.state}, priority: {of: job => job.priority, down: true},
  submitted: {of: job => job.submitted, down: true}, finished: {of: job => job.finished, down: true},
  taken: {of: job => job.seconds_taken, down: true}, progress: {of: job => job.progress, down: true}};

const orderOf = sort => sorts[sort].down ? 'desc' : 'asc';

/** Reads the part of the address after "?". Replaces unknown values by the defaults. */
export function parseQuery(text) {
  const given = new URLSearchParams(text ?? '');
  const state = given.get('state');
  const sort = sorts[given.get('sort')] ? given.get('sort') : 'id';
  const order = given.get('order');
  return {q: given.get('q') ?? '', user: given.get('user') ?? '', state: filters.has(state) ? state : 'all',
    mine: given.get('mine') === '1', sort, order: ['asc', 'desc'].includes(order) ? order : orderOf(sort)};
}

/** Writes a query as part of the address, "" for the default. */
export function formatQuery({q, user, state, mine, sort, order}) {
  const text = new URLSearchParams();
  if (q) text.set('q', q);
  if (user) text.set('user', user);
  if (state !== 'all') text.set('state', state);
  if (mine) text.set('mine', '1');
  if (sort !== 'id') text.set('sort', sort);
  if (order !== orderOf(sort)) text.set('order', order);
  return text.toString();
}

/** Returns the order after a click on the head of a column. */
export const sortedBy = ({sort, order}, next) => next === sort ? {sort, order: order === 'asc' ? 'desc' : 'asc'} :
  {sort: next, order: orderOf(next)};

/** Returns the parameters of GET /jobs. `me`: the name of this user. */
export function requestOf({q, user, state, mine, sort, order}, me) {
  const of = {};
  if (state !== 'all') of.state = filters.get(state).join(',');
  if (q) of.name = q;
  if (mine && me || user) of.user = mine && me ? me : user;
  if (sort !== 'id' || order !== 'desc') Object.assign(of, {sort, order});
  return of;
}

/** Returns a function that tells whether the query selects a job. A number in the search field is a job's number, too. */
export function matcherOf({q, user, state, mine}, me) {
  const states = filters.get(state);
  const part = lower(q);
  const of = mine && me ? me : user;
  return job => job.frame === undefined && (!states.length || states.includes(job.state)) && (!of || job.user === of) &&
    (!part || lower(job.name).includes(part) || String(job.id) === part);
}

/** Returns a comparison of two jobs, the same as the server's. An unknown value is less than all others; equal jobs are
 *  ordered from new to old. */
export function comparisonOf({sort, order}) {
  const {of} = sorts[sort];
  const sign = order === 'asc' ? 1 : -1;
  if (sort === 'id') return (a, b) => sign * (a.id - b.id);
  return (a, b) => {
    const [x, y] = [of(a) ?? -1, of(b) ?? -1];
    if (x === y) return b.id - a.id;
    return x < y ? -sign : sign;
  };
}
