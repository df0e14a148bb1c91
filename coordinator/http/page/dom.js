// Elements. Names of scenes, users, files and workers are strangers' text: nothing here, nor anywhere
// in the page, makes markup of a string.

/** An element. `attributes`: on... is a listener, true an attribute without a value, false and
 *  undefined none. Strings among `children` become text. */
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

export const button = (text, onclick, attributes = {}) =>
  el('button', {type: 'button', onclick, ...attributes}, text);

/** Writing the same text again would cost a layout. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function setClass(node, name) {
  if (node.className !== name) node.className = name;
}

/** A list of facts: [[term, value]], value text or an element; those without a value are left out. */
export function facts(pairs) {
  return el('dl', {class: 'facts'}, ...pairs
    .filter(([, value]) => value !== undefined && value !== null && value !== '')
    .flatMap(([term, value]) => [el('dt', {}, term), el('dd', {}, value)]));
}

let notes;

/** Says something in passing: `kind` is note or error. */
export function say(text, kind = 'note') {
  notes ??= document.getElementById('notes');
  const note = el('p', {class: kind, role: kind === 'error' ? 'alert' : undefined}, text,
    button('×', () => note.remove(), {class: 'quiet', 'aria-label': 'Dismiss'}));
  notes.append(note);
  while (notes.childElementCount > 4) notes.firstChild.remove();
  setTimeout(() => note.remove(), kind === 'error' ? 20000 : 6000);
}

/** A dialog that is gone when it is closed; `build(close)` gives its children. Resolves to what
 *  `close` was given, undefined after Escape. */
export function ask(label, build) {
  return new Promise(resolve => {
    let answer;
    const dialog = el('dialog', {'aria-label': label});
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
  });
}

/** Asks before what cannot be undone; the harmless answer has the focus. */
export function confirm(question, detail, yes, ...more) {
  return ask(question, close => [
    el('h2', {}, question), el('p', {}, detail), ...more,
    el('div', {class: 'answers'},
      button('Leave it', () => close(false), {autofocus: true}),
      button(yes, () => close(true), {class: 'danger'}))]);
}
