// The quick look of a job: a small job that shows a first picture. This tab remembers the quick looks that it
// has submitted; the server names them, too (`preview_of`).

const place = 'parray-quick-looks';
const known = () => JSON.parse(sessionStorage.getItem(place) ?? '{}');

export const quickWidth = 300;
export const quickSamples = 16;

export const quickLookOf = id => known()[id];

export function rememberQuickLook(id, quick) {
  const latest = Object.entries(known()).slice(-50);
  sessionStorage.setItem(place, JSON.stringify({...Object.fromEntries(latest), [id]: quick}));
}

/** Returns the options of the quick look of job `id`. `options`: those of the job. `numbers`: width and height of
 *  its picture without options. */
export function quickLookOptions(options, numbers, id) {
  const {target_error, target_half_width, time_limit, denoise, quality, webhook, ...rest} = options;
  const {name, spp = quickSamples, priority = 50} = rest;
  const [width, height] = [rest.width ?? numbers.width, rest.height ?? numbers.height];
  const small = Math.min(quickWidth, width);
  return {...rest, name: name.slice(0, 115) + ' (quick look)', width: small, height: Math.max(1, Math.round(small * height / width)),
    spp: Math.min(quickSamples, spp), priority: Math.min(100, priority + 1), progressive: true, preview_of: id};
}
