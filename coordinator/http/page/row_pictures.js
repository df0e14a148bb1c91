// Thumbnails in the rows of a list. Rows change their jobs while the list scrolls, so each picture is requested for
// the job that a row shows at that time.

import {loadThumbnail} from './thumbnails.js';

const width = 64;  // pixels
const mostRequests = 3;
const mostPictures = 400;  // kept in memory, about 4 KB each
const settle = 120;  // ms that a row must show a job before its picture is requested
const changeEvery = 20000;  // ms between two pictures of a running job
const againAfter = 30000;  // ms after a failed request

export class RowPictures {
  #known = new Map();  // job: {url, state, at}, the job that was shown last is the last
  #wanted = new Map();  // image: job
  #shown = new WeakMap();  // image: number of the job in its row
  #loading = 0;
  #timer;
  #stop = new AbortController();
  on = true;

  /** Shows the picture of `job` in `image`, an <img> of a row, as soon as it has one. */
  show(image, job) {
    const known = this.#known.get(job.id);
    this.#shown.set(image, job.id);
    if (!this.on || job.has_picture !== true) {
      image.hidden = true;
      this.#wanted.delete(image);
      return;
    }
    this.#put(image, known?.url);
    const age = performance.now() - (known?.at ?? 0);
    if (!known || known.state !== job.state || age > (!known.url ? againAfter : job.state === 'running' ? changeEvery : Infinity)) {
      if (this.#wanted.get(image) === job) return;
      this.#wanted.set(image, job);
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.#next(), settle);
    } else {
      this.#wanted.delete(image);
    }
  }

  /** Forgets all pictures. */
  clear() {
    this.#stop.abort();
    this.#stop = new AbortController();
    this.#wanted.clear();
    for (const {url} of this.#known.values()) if (url) URL.revokeObjectURL(url);
    this.#known.clear();
  }

  #put(image, url) {
    image.hidden = !url;
    if (url && image.src !== url) image.src = url;
  }

  #next() {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    for (const [image, job] of this.#wanted) {
      if (this.#loading >= mostRequests) return;
      this.#wanted.delete(image);
      if (image.isConnected && !image.closest('[hidden].row')) this.#load(image, job);
    }
  }

  async #load(image, job) {
    ++this.#loading;
    const entry = {state: job.state, at: performance.now(), url: this.#known.get(job.id)?.url};
    this.#known.set(job.id, entry);
    try {
      const url = await loadThumbnail(job.id, width, this.#stop.signal);
      if (entry.url) URL.revokeObjectURL(entry.url);
      entry.url = url;
      this.#known.delete(job.id);
      this.#known.set(job.id, entry);
      this.#limit();
      if (this.#shown.get(image) === job.id) this.#put(image, url);
    } catch {
      // The row stays without a picture, as for a job that has none.
    }
    --this.#loading;
    this.#next();
  }

  #limit() {
    for (const [id, {url}] of this.#known) {
      if (this.#known.size <= mostPictures) return;
      if (url) URL.revokeObjectURL(url);
      this.#known.delete(id);
    }
  }
}
