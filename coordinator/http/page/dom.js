// Creates elements. Names of scenes, users, files and workers are untrusted text, so the page never
// interprets a string as markup.

/** Creates an element. `attributes`: on... adds a listener, true sets an attribute without a value, false
 *  and undefined set nothing. Strings in `children` become text. */
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.filter(child => child !== undefined && child !== null));
  return node;
}

/** Creates an element of SVG. */
export function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

export const button = (text, onclick, attributes = {}) =>
  el('button', {type: 'button', onclick, ...attributes}, text);

/** Sets the text. Does nothing if the text is the same, because writing it again would cost a layout. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function setClass(node, name) {
  if (node.className !== name) node.className = name;
}

/** Creates a list of facts from [[term, value]]. A value is a text or an element. Omits facts without a value. */
export function facts(pairs) {
  return el('dl', {class: 'facts'}, ...pairs
    .filter(([, value]) => value !== undefined && value !== null && value !== '')
    .flatMap(([term, value]) => [el('dt', {}, term), el('dd', {}, value)]));
}

let notes;

/** Shows a notification for some seconds. `kind`: note or error. */
export function notify(text, kind = 'note') {
  notes ??= document.getElementById('notes');
  const note = el('p', {class: kind, role: kind === 'error' ? 'alert' : undefined}, text,
    button('×', () => note.remove(), {class: 'quiet', 'aria-label': 'Dismiss'}));
  notes.append(note);
  while (notes.childElementCount > 4) notes.firstChild.remove();
  setTimeout(() => note.remove(), kind === 'error' ? 20000 : 6000);
}

/** Shows a dialog. `build(close)` returns its children. Resolves to the argument of `close`, or to undefined
 *  after Escape. `kind`: a class of the style sheet. */
export function ask(label, build, kind) {
  return new Promise(resolve => {
    let answer;
    const dialog = el('dialog', {'aria-label': label, class: kind});
    dialog.addEventListener('close', () => {
      dialog.remove();
      resolve(answer);
    });
    dialog.append(...build(value => {
      answer = value;
      dialog.close();
    }));
    document.body.append(dialog);
    dialog.showModal();
    dialog.scrollTop = 0;  // the button that has the focus may be at the end
  });
}

/** Asks for confirmation. `no`, the label of the harmless answer, has the focus. Resolves to true for `yes`. */
export function confirm(question, detail, no, yes, ...more) {
  return ask(question, close => [
    el('h2', {}, question), el('p', {}, detail), ...more,
    el('div', {class: 'answers'},
      button(no, () => close(false), {autofocus: true}),
      button(yes, () => close(true), {class: 'danger'}))]);
}

/** Sets an attribute. Does nothing if it has this value. undefined removes it. */
export function setAttribute(node, name, value) {
  if (value === undefined) node.removeAttribute(name);
  else if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
}
