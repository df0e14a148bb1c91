// Loads thumbnails of jobs: a few requests at a time, and only for elements that are visible. An <img> could not
// send the token.

import {request} from './api.js';

const mostRequests = 4;

export class Thumbnails {
  #width;
  #waiting = new Map();  // element: function that loads it
  #loading = 0;
  #observer;
  #stop = new AbortController();

  /** `width`: of the thumbnails, in pixels. */
  constructor(width) {
    this.#width = width;
    this.#observer = new IntersectionObserver(entries => {
      for (const {target, isIntersecting} of entries) {
        const waiting = this.#waiting.get(target);
        if (waiting) waiting.visible = isIntersecting;
      }
      this.#next();
    }, {rootMargin: '200px'});
  }

  /** Loads the picture of job `id` into `image`, an <img>, when it is visible. */
  load(image, id) {
    this.#waiting.set(image, {id, visible: false});
    this.#observer.unobserve(image);
    this.#observer.observe(image);
  }

  /** Forgets everything that is not loaded yet. */
  clear() {
    this.#stop.abort();
    this.#stop = new AbortController();
    this.#observer.disconnect();
    this.#waiting.clear();
  }

  #next() {
    for (const [image, {id, visible}] of this.#waiting) {
      if (this.#loading >= mostRequests) return;
      if (!visible) continue;
      this.#waiting.delete(image);
      this.#observer.unobserve(image);
      this.#loadNow(image, id);
    }
  }

  async #loadNow(image, id) {
    ++this.#loading;
    try {
      const url = await loadThumbnail(id, this.#width, this.#stop.signal);
      const old = image.src;
      image.src = url;
      if (old) URL.revokeObjectURL(old);
    } catch {
      // The cell stays without a picture, as for a job that has none.
    }
    --this.#loading;
    this.#next();
  }
}

/** Loads a thumbnail. Returns the URL of an object, which the caller revokes. Throws Problem. */
export async function loadThumbnail(id, width, signal) {
  const response = await request('GET', `jobs/${id}/image.png?width=${width}`, {signal});
  return URL.createObjectURL(await response.blob());
}
