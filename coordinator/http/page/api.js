// Sends requests to the HTTP interface (openapi.json). Does not depend on the page.

/** A failed request. `message`: the server's error message. `status`: HTTP status; 0: the server could not be reached. */
export class Problem extends Error {
  constructor(status, detail) {
    super(detail);
    this.status = status;
  }
}

const tokenPlace = 'parray-token';
/** The token of this user. This tab keeps it, or this browser until the user signs out. */
export const token = {
  place: tokenPlace,
  get: () => sessionStorage.getItem(tokenPlace) ?? localStorage.getItem(tokenPlace) ?? '',
  set: (value, keep) => {
    token.forget();
    (keep ? localStorage : sessionStorage).setItem(tokenPlace, value);
  },
  forget: () => {
    sessionStorage.removeItem(tokenPlace);
    localStorage.removeItem(tokenPlace);
  },
};

// Relative to the page, so that a proxy may serve the page under another path.
const address = path => new URL('api/v1/' + path, document.baseURI);

const authorization = () => token.get() ? {Authorization: 'Bearer ' + token.get()} : {};

export function problemOf(status, text) {
  try {
    return new Problem(status, JSON.parse(text).detail ?? text);
  } catch {
    return new Problem(status, text.slice(0, 300) || `the server answered with status ${status}`);
  }
}

/** Sends a request and returns the response. Throws Problem for a status of 400 or more. */
export async function request(method, path, {headers = {}, body, signal} = {}) {
  let response;
  try {
    response = await fetch(address(path), {
      method, body, signal, headers: {...authorization(), ...headers}, cache: 'no-store',
      redirect: 'error', referrerPolicy: 'no-referrer'});
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Problem(0, 'the coordinator cannot be reached');
  }
  if (response.status >= 400) throw problemOf(response.status, await response.text());
  return response;
}

export const getJson = async (path, signal) => (await request('GET', path, {signal})).json();

/** Sends a POST, PUT or DELETE. Returns the JSON of the answer, or undefined if the answer has no body. */
export async function change(method, path, value) {
  const response = await request(method, path, value === undefined ? {} : {
    headers: {'Content-Type': 'application/json'}, body: JSON.stringify(value)});
  return response.status === 204 ? undefined : response.json();
}

/** Receives server-sent events: calls opened(), then take(event, data) for each event. Returns when the
 *  stream ends. An EventSource cannot send a token. `silence`: milliseconds without a byte after which
 *  the connection counts as lost. Throws Problem. */
export async function listen(path, {opened, take, signal, silence = 20000}) {
  const stop = new AbortController();
  signal?.addEventListener('abort', () => stop.abort());
  let watchdog;
  const alive = () => {
    clearTimeout(watchdog);
    watchdog = setTimeout(() => stop.abort(), silence);
  };
  alive();
  try {
    const response = await request('GET', path, {headers: {Accept: 'text/event-stream'}, signal: stop.signal});
    opened();
    const parser = new EventParser(take);
    const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
    for (;;) {
      const {done, value} = await reader.read();
      if (done) return;
      alive();
      parser.add(value);
    }
  } catch (error) {
    if (error instanceof Problem) throw error;
    throw new Problem(0, 'the connection was lost');
  } finally {
    clearTimeout(watchdog);
    stop.abort();
  }
}

/** Parses text/event-stream: event, data and comments, the parts that the server uses. */
export class EventParser {
  #rest = '';
  #event = '';
  #data = [];
  #take;
  constructor(take) {
    this.#take = take;
  }
  add(text) {
    const lines = (this.#rest + text).split('\n');
    this.#rest = lines.pop();
    for (const raw of lines) {
      const line = raw.endsWith('\r') ? raw.slice(0, -1) : raw;
      if (line === '') this.#dispatch();
      else if (line.startsWith('event:')) this.#event = line.slice(6).trim();
      else if (line.startsWith('data:')) this.#data.push(line.slice(5));
    }
  }
  #dispatch() {
    if (this.#data.length) this.#take(this.#event, JSON.parse(this.#data.join('\n')));
    this.#event = '';
    this.#data = [];
  }
}

/** Sends a scene with its files and options as a form. Returns the JSON of the answer. `to`: jobs or plan. Calls
 *  progress(share) during the upload, which fetch cannot do. */
export function submit({to = 'jobs', scene, files, options, key, progress = () => {}, signal}) {
  const form = new FormData();
  if (scene) form.append('scene', scene, scene.name);
  form.append('options', new Blob([JSON.stringify(options)], {type: 'application/json'}));
  for (const file of files) form.append(file.name, file, file.name);
  return new Promise((resolve, reject) => {
    const sending = new XMLHttpRequest();
    sending.open('POST', address(to));
    for (const [name, value] of Object.entries({...authorization(), ...key ? {'Idempotency-Key': key} : {}})) {
      sending.setRequestHeader(name, value);
    }
    sending.upload.onprogress = event => event.lengthComputable && progress(event.loaded / event.total);
    sending.onerror = () => reject(new Problem(0, 'the coordinator cannot be reached'));
    sending.onabort = () => reject(new Problem(0, 'the request was cancelled'));
    sending.onload = () => sending.status < 300 ? resolve(JSON.parse(sending.responseText)) :
      reject(problemOf(sending.status, sending.responseText));
    signal?.addEventListener('abort', () => sending.abort());
    sending.send(form);
  });
}

/** Downloads `path` as a file. A plain link could not send the token. */
export async function download(path, name) {
  const blob = await (await request('GET', path)).blob();
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
