// Shows a picture on a canvas, with zoom, exposure and the value under the cursor. Works with mouse, touch,
// keys and buttons.

import {button, el, setText} from './dom.js';
import {kinds, paintMap, paintScale, textOf, workerColour} from './maps.js';
import {paintRadiance} from './picture.js';
import {channel, radiance, small} from './format.js';

const slice = 1 << 18;  // pixels painted without a pause: about 5 ms
const mostZoom = 64;

export class Viewer {
  #picture;  // from fetchPicture
  #maps = {};  // from fetchMap, by kind
  #below;  // a small picture that is visible where the picture has no samples yet
  #belowSurface = document.createElement('canvas');
  #layer = 'picture';
  #surface = document.createElement('canvas');  // the picture at its own resolution
  #painting = 0;
  #scale = 0;  // CSS pixels per pixel; 0: fit
  #x = 0;  // position of the picture's corner in CSS pixels
  #y = 0;
  #cursor;
  #pointers = new Map();
  #drawn = 0;

  constructor() {
    this.canvas = el('canvas', {});
    this.readout = el('output', {class: 'readout', 'aria-live': 'off'});
    this.spoken = el('p', {class: 'unseen', 'aria-live': 'polite'});
    this.message = el('p', {class: 'message', role: 'status', hidden: true});
    this.stage = el('div', {class: 'stage', tabindex: 0, role: 'application', 'aria-label': 'Picture',
      'aria-roledescription': 'picture viewer',
      'aria-keyshortcuts': '+ - 0 1 ArrowLeft ArrowRight ArrowUp ArrowDown [ ] m'}, this.canvas, this.message);
    this.exposure = el('input', {type: 'range', min: -6, max: 6, step: 0.25, value: 0, 'aria-label': 'Exposure, stops',
      oninput: () => this.#expose(), ondblclick: () => this.#setExposure(0)});
    this.stops = button('0 EV', () => {
      this.#setExposure(0);
      this.exposure.focus();
    }, {class: 'stops quiet', title: 'Reset the exposure', disabled: true});
    this.zoomed = el('output', {class: 'zoomed'});
    this.layers = el('select', {'aria-label': 'Layer', onchange: () => this.setLayer(this.layers.value)},
      el('option', {value: 'picture'}, 'Picture'),
      ...Object.entries(kinds).map(([kind, {title}]) => el('option', {value: kind}, title)));
    this.low = el('span', {});
    this.high = el('span', {});
    const scale = el('canvas', {class: 'ramp', 'aria-hidden': 'true'});
    paintScale(scale);
    this.legendText = el('span', {});
    this.legendScale = el('span', {class: 'scale'}, this.low, scale, this.high);
    this.legendNames = el('span', {class: 'names'});
    this.exposing = el('div', {class: 'exposure'}, el('label', {}, el('span', {}, 'Exposure'), this.exposure), this.stops);
    // Takes the place of the exposure, which changes the picture only. So the stage keeps its size.
    this.legend = el('p', {class: 'legend', hidden: true}, this.legendText, this.legendScale, this.legendNames);
    this.tools = el('div', {class: 'viewer-tools', role: 'group', 'aria-label': 'View of the picture'},
      button('−', () => this.zoomBy(1 / 1.5), {'aria-label': 'Zoom out'}), this.zoomed,
      button('+', () => this.zoomBy(1.5), {'aria-label': 'Zoom in'}),
      button('Fit', () => this.fit()), button('1 : 1', () => this.zoomTo(1 / devicePixelRatio)),
      this.layers, this.exposing, this.legend);
    this.element = el('div', {class: 'viewer'}, this.stage, this.tools, el('div', {class: 'values'}, this.readout), this.spoken);
    this.#listen();
  }

  /** Shows a picture. `below`: a small version of it that is visible where samples are missing, or undefined. */
  show(picture, below) {
    this.#picture = picture;
    this.#below = below;
    if (this.#layer === 'picture') this.#paint();
    else if (picture.partial) this.#loadLayer();
    this.#showReadout();
  }

  /** Loads a map: async (kind) => map from fetchMap. Throws an Error, whose message is shown. */
  loadMap = undefined;

  showMap(map) {
    this.#maps[map.kind] = map;
    if (this.#layer === map.kind) {
      this.#showLegend(map);
      this.#paint();
    }
    this.#showReadout();
  }

  showMessage(text) {
    setText(this.message, text);
    this.message.hidden = !text;
  }

  /** Disables a map. `reason`: why there is no such map, in a few words; empty enables the map. */
  disableMap(kind, reason) {
    const option = [...this.layers.options].find(each => each.value === kind);
    option.disabled = Boolean(reason);
    setText(option, kinds[kind].title + (reason ? ` (${reason})` : ''));
    if (reason && this.#layer === kind) this.setLayer('picture');
  }

  clear() {
    this.#picture = this.#below = this.#cursor = undefined;
    this.#maps = {};
    this.#scale = 0;
    this.#surface.width = this.#surface.height = 0;
    setText(this.spoken, '');
    this.#setExposure(0);
    this.setLayer('picture');
    this.#draw();
  }

  /** Selects what is shown: 'picture' or a kind of map. */
  setLayer(layer) {
    this.#layer = this.layers.value = layer;
    this.showMessage('');
    this.legend.hidden = layer === 'picture';
    this.exposing.hidden = layer !== 'picture';
    this.#showReadout();
    if (layer === 'picture') this.#paint();
    else if (this.#maps[layer]) this.showMap(this.#maps[layer]);
    else this.#loadLayer();
  }

  #loading;
  async #loadLayer() {
    const layer = this.#layer;
    if (this.#loading === layer) return;
    this.#loading = layer;
    try {
      this.showMap(await this.loadMap(layer));
    } catch (problem) {
      if (this.#layer === layer && problem.name !== 'AbortError') {
        this.setLayer('picture');
        this.showMessage(problem.message);
      }
    } finally {
      this.#loading = undefined;
    }
  }

  #showLegend({kind, low, high, names}) {
    setText(this.legendText, kinds[kind].legend);
    this.legendScale.hidden = Boolean(names);
    this.legendNames.replaceChildren();
    if (names) {
      const most = 24;
      this.legendNames.append(...names.slice(0, most).map((name, i) => {
        const mark = el('span', {class: 'mark', 'aria-hidden': 'true'});
        mark.style.background = workerColour(i);
        return el('span', {}, mark, name);
      }), names.length > most ? `and ${names.length - most} more` : '');
    } else {
      const text = kind === 'cost' ? value => small(value, 's') : radiance;
      setText(this.low, text(low));
      setText(this.high, text(high));
    }
  }

  fit() {
    this.#scale = 0;
    this.#draw();
  }

  zoomTo(scale, x = this.stage.clientWidth / 2, y = this.stage.clientHeight / 2) {
    if (!this.#picture) return;
    const {scale: old, left, top} = this.#place();
    this.#scale = Math.min(mostZoom, Math.max(0.02, scale));
    this.#x = x - (x - left) * this.#scale / old;
    this.#y = y - (y - top) * this.#scale / old;
    this.#draw();
  }

  zoomBy(factor, x, y) {
    this.zoomTo(this.#place().scale * factor, x, y);
  }

  /** Returns scale and position of the picture on the stage. */
  #place() {
    const {width, height} = this.#picture ?? {width: 1, height: 1};
    const {clientWidth, clientHeight} = this.stage;
    if (this.#scale === 0) {
      const scale = Math.min(mostZoom, clientWidth / width, clientHeight / height);
      return {scale, left: (clientWidth - width * scale) / 2, top: (clientHeight - height * scale) / 2};
    }
    return {scale: this.#scale, left: this.#x, top: this.#y};
  }

  #setExposure(stops) {
    this.exposure.value = stops;
    this.#expose();
  }

  #expose() {
    const stops = Number(this.exposure.value);
    setText(this.stops, `${stops > 0 ? '+' : ''}${stops} EV${stops ? ' ↺' : ''}`);
    this.stops.disabled = stops === 0;
    this.exposure.setAttribute('aria-valuetext', `${stops} stops`);
    if (this.#layer === 'picture') this.#paint();
  }

  /** Paints the surface in slices, so that a large picture does not block the page. */
  async #paint() {
    const mine = ++this.#painting;
    const {width, height} = this.#picture ?? {};
    if (!width) return;
    if (this.#surface.width !== width || this.#surface.height !== height) {
      this.#surface.width = width;
      this.#surface.height = height;
    }
    const context = this.#surface.getContext('2d');
    const rows = Math.max(1, Math.floor(slice / width));
    const gain = 2 ** Number(this.exposure.value);
    if (this.#below) this.#paintBelow(gain);
    for (let top = 0; top < height; top += rows) {
      const image = new ImageData(width, Math.min(rows, height - top));
      const words = new Uint32Array(image.data.buffer);
      const begin = top * width;
      const map = this.#maps[this.#layer];
      if (map) paintMap(map, words, begin, begin + words.length);
      else paintRadiance(this.#picture, words, begin, begin + words.length, gain, !this.#picture.partial);
      context.putImageData(image, 0, top);
      if (top + rows < height) {
        this.#draw();
        await new Promise(requestAnimationFrame);
        if (mine !== this.#painting) return;
      }
    }
    this.#draw();
  }

  #paintBelow(gain) {
    const {width, height} = this.#below;
    Object.assign(this.#belowSurface, {width, height});
    const image = new ImageData(width, height);
    paintRadiance(this.#below, new Uint32Array(image.data.buffer), 0, width * height, gain, !this.#below.partial);
    this.#belowSurface.getContext('2d').putImageData(image, 0, 0);
  }

  #draw() {
    if (this.#drawn) return;
    this.#drawn = requestAnimationFrame(() => {
      this.#drawn = 0;
      this.#drawNow();
    });
  }

  #drawNow() {
    const ratio = devicePixelRatio;
    const {clientWidth, clientHeight} = this.stage;
    const [width, height] = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const context = this.canvas.getContext('2d');
    context.clearRect(0, 0, width, height);
    if (!this.#picture || !this.#surface.width) return;
    const {scale, left, top} = this.#place();
    setText(this.zoomed, Math.round(scale * ratio * 100) + ' %');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const box = [left, top, this.#picture.width * scale, this.#picture.height * scale];
    context.imageSmoothingQuality = 'high';
    context.fillStyle = getComputedStyle(this.stage).getPropertyValue('--untraced');
    context.fillRect(...box);
    if (this.#below && this.#picture.partial && this.#layer === 'picture') {
      context.imageSmoothingEnabled = true;
      context.drawImage(this.#belowSurface, ...box);
    }
    context.imageSmoothingEnabled = scale * ratio < 1;
    context.drawImage(this.#surface, ...box);
    this.#drawCursor(context, scale, left, top);
  }

  #drawCursor(context, scale, left, top) {
    if (!this.#cursor) return;
    const size = Math.max(scale, 5);
    const middle = (at, origin) => origin + (at + 0.5) * scale - size / 2;
    const [x, y] = [middle(this.#cursor.x, left), middle(this.#cursor.y, top)];
    for (const [grow, colour] of [[1.5, 'black'], [0.5, 'white']]) {
      context.strokeStyle = colour;
      context.lineWidth = 1;
      context.strokeRect(x - grow, y - grow, size + 2 * grow, size + 2 * grow);
    }
  }

  #showReadout() {
    const {x, y} = this.#cursor ?? {};
    const picture = this.#picture;
    if (x === undefined || !picture || x >= picture.width || y >= picture.height) {
      setText(this.readout, !picture ? '' :
        `${picture.width} × ${picture.height}, ${picture.none ? 'quick look' : picture.exact ? 'linear float32' : '8-bit'}`);
      return;
    }
    const at = y * picture.width + x;
    const [r, g, b] = picture.pixels.subarray(3 * at, 3 * at + 3);
    let text = `x ${x}  y ${y}   R ${channel(r)}  G ${channel(g)}  B ${channel(b)}`;
    if (picture.partial && r === 0 && g === 0 && b === 0) text = `x ${x}  y ${y}   no sample yet`;
    if (!picture.exact) text += '   (8-bit)';
    for (const map of Object.values(this.#maps)) {
      if (map.kind === this.#layer || map.kind === 'error' && !picture.partial) text += '   ' + textOf(map, at);
    }
    setText(this.readout, text);
  }

  #moveCursor(x, y, aloud) {
    const {width, height} = this.#picture ?? {};
    if (!width) return;
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    if (!inside && !aloud) this.#cursor = undefined;
    else this.#cursor = {x: Math.min(width - 1, Math.max(0, x)), y: Math.min(height - 1, Math.max(0, y))};
    this.#showReadout();
    if (aloud) {
      this.#follow();
      setText(this.spoken, this.readout.textContent);
    }
    this.#draw();
  }

  /** Moves the picture so that the cursor stays on the stage. */
  #follow() {
    if (this.#scale === 0) return;
    const shift = (at, origin, size) => {
      const here = origin + (at + 0.5) * this.#scale;
      return here < 20 ? 20 - here : here > size - 20 ? size - 20 - here : 0;
    };
    this.#x += shift(this.#cursor.x, this.#x, this.stage.clientWidth);
    this.#y += shift(this.#cursor.y, this.#y, this.stage.clientHeight);
  }

  #at(event) {
    const box = this.stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #listen() {
    const stage = this.stage;
    stage.addEventListener('wheel', event => {
      event.preventDefault();
      this.zoomBy(2 ** (-event.deltaY * (event.deltaMode ? 20 : 1) / 300), ...this.#at(event));
    }, {passive: false});
    stage.addEventListener('dblclick', event => this.#scale === 0 ? this.zoomTo(8, ...this.#at(event)) : this.fit());
    stage.addEventListener('pointerdown', event => {
      stage.setPointerCapture(event.pointerId);
      this.#pointers.set(event.pointerId, this.#at(event));
    });
    for (const end of ['pointerup', 'pointercancel']) {
      stage.addEventListener(end, event => this.#pointers.delete(event.pointerId));
    }
    stage.addEventListener('pointermove', event => this.#pointerMoved(event));
    stage.addEventListener('pointerleave', () => this.#pointers.size || this.#moveCursor(-1, -1));
    stage.addEventListener('keydown', event => this.#key(event));
    new ResizeObserver(() => this.#draw()).observe(stage);
  }

  #pointerMoved(event) {
    const now = this.#at(event);
    const before = this.#pointers.get(event.pointerId);
    if (before) {
      const others = [...this.#pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      this.#pointers.set(event.pointerId, now);
      if (others.length) this.#pinch(others[0], before, now);
      else this.#pan(now[0] - before[0], now[1] - before[1]);
    }
    const {scale, left, top} = this.#place();
    this.#moveCursor(Math.floor((now[0] - left) / scale), Math.floor((now[1] - top) / scale));
  }

  #pan(dx, dy) {
    const {scale, left, top} = this.#place();
    [this.#scale, this.#x, this.#y] = [scale, left + dx, top + dy];
    this.#draw();
  }

  #pinch(fixed, before, now) {
    const distance = at => Math.hypot(at[0] - fixed[0], at[1] - fixed[1]);
    if (distance(before) > 0) this.zoomBy(distance(now) / distance(before), ...fixed);
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = event.shiftKey ? 10 : 1;
    const by = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step]}[event.key];
    const expose = stops => this.#layer === 'picture' && this.#setExposure(Number(this.exposure.value) + stops);
    if (by && this.#picture) {
      const from = this.#cursor ?? {x: this.#picture.width >> 1, y: this.#picture.height >> 1};
      this.#moveCursor(from.x + by[0], from.y + by[1], true);
    } else if (event.key === '+' || event.key === '=') this.zoomBy(1.5, ...this.#focus());
    else if (event.key === '-') this.zoomBy(1 / 1.5, ...this.#focus());
    else if (event.key === '0') this.fit();
    else if (event.key === '1') this.zoomTo(1 / devicePixelRatio, ...this.#focus());
    else if (event.key === '[') expose(-0.5);
    else if (event.key === ']') expose(0.5);
    else if (event.key === 'm') {
      const layers = [...this.layers.options].filter(option => !option.disabled).map(option => option.value);
      this.setLayer(layers[(layers.indexOf(this.#layer) + 1) % layers.length]);
    }
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Returns the point that zooming by keys keeps in place: the cursor, or nothing for the centre. */
  #focus() {
    if (!this.#cursor) return [];
    const {scale, left, top} = this.#place();
    return [left + (this.#cursor.x + 0.5) * scale, top + (this.#cursor.y + 0.5) * scale];
  }
}
