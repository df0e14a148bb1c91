// Which small job gives a first impression of which: known to this tab only.

const place = 'parray-quick-looks';
const known = () => JSON.parse(sessionStorage.getItem(place) ?? '{}');

export const quickLookOf = id => known()[id];

export function rememberQuickLook(id, quick) {
  const latest = Object.entries(known()).slice(-50);
  sessionStorage.setItem(place, JSON.stringify({...Object.fromEntries(latest), [id]: quick}));
}
