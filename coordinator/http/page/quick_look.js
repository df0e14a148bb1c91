// Remembers the quick look of each job: a small job that shows a first picture. Only this tab knows it.

const place = 'parray-quick-looks';
const known = () => JSON.parse(sessionStorage.getItem(place) ?? '{}');

export const quickLookOf = id => known()[id];

export function rememberQuickLook(id, quick) {
  const latest = Object.entries(known()).slice(-50);
  sessionStorage.setItem(place, JSON.stringify({...Object.fromEntries(latest), [id]: quick}));
}
