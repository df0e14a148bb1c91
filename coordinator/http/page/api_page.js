// The page /api: shows the description of the HTTP interface (openapi.json), with commands to copy.

import {getJson} from './api.js';
import {button, el, facts, notify} from './dom.js';

const main = document.getElementById('main');
const methods = ['get', 'post', 'put', 'delete'];
const isBinary = type => /^(image\/|application\/(octet-stream|zip))/.test(type);

/** Returns readable JSON: whatever fits is on one line. A text stays as it is. */
function json(value) {
  const text = (part, pad) => {
    const line = JSON.stringify(part, null, 1).replace(/\n\s*/g, ' ').replace(/([[{]) | ([\]}])/g, '$1$2');
    if (typeof part !== 'object' || part === null || pad.length + line.length < 88) return line;
    const [open, close] = Array.isArray(part) ? '[]' : '{}';
    const inner = pad + '  ';
    const items = Object.entries(part).map(([key, item]) =>
      inner + (open === '{' ? JSON.stringify(key) + ': ' : '') + text(item, inner));
    return `${open}\n${items.join(',\n')}\n${pad}${close}`;
  };
  return typeof value === 'string' ? value : text(value, '');
}

/** Returns the nodes of a text in which backticks mark code. */
const prose = text => (text ?? '').split('`').map((part, i) => i % 2 ? el('code', {}, part) : part);

/** Follows references within the document. */
function resolver(document) {
  const resolve = part => part?.$ref
    ? resolve(part.$ref.split('/').slice(1).reduce((at, key) => at[key], document)) : part ?? {};
  return resolve;
}

const nameOf = reference => reference.split('/').pop();

/** Returns the nodes that say which values a schema permits. A named schema of a map becomes a link. */
function typeNodes(schema, resolve) {
  if (schema.$ref && resolve(schema).properties) {
    const name = nameOf(schema.$ref);
    return [el('a', {href: '#schema-' + name}, name)];
  }
  const plain = resolve(schema);
  if (plain.type === 'array') return ['list of ', ...typeNodes(plain.items ?? {}, resolve)];
  if (plain.enum) return [plain.enum.join(', ')];
  const {minimum: least, maximum: most} = plain;
  const range = least !== undefined && most < 1e12 ? ` ${least} to ${most}` : least !== undefined ? ` from ${least}` : '';
  const fallback = plain.default === undefined ? '' : `, default ${plain.default}`;
  return [[plain.type ?? 'any'].flat().join(' or ') + range + fallback];
}

/** Creates a table. `rows`: lists of cells; a cell is a list of nodes. The first cell is the row's header. */
function table(caption, heads, rows) {
  return el('table', {}, el('caption', {}, caption),
    el('thead', {}, el('tr', {}, ...heads.map(head => el('th', {scope: 'col'}, head)))),
    el('tbody', {}, ...rows.map(([first, ...cells]) =>
      el('tr', {}, el('th', {scope: 'row'}, ...first), ...cells.map(cell => el('td', {}, ...cell))))));
}

function propertyTable(caption, schema, resolve) {
  const required = new Set(schema.required);
  return table(caption, ['Field', 'Value', 'Meaning'], Object.entries(schema.properties ?? {}).map(([name, part]) =>
    [[el('code', {}, name), required.has(name) ? '' : ' (optional)'], typeNodes(part, resolve), prose(part.description)]));
}

const quoted = text => /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;

/** Returns the arguments of curl that send the example of a body. */
function bodyWords(type, {example, schema}, resolve) {
  if (type !== 'multipart/form-data') return ['-H', quoted('Content-Type: ' + type), '-d', quoted(JSON.stringify(example))];
  const known = resolve(schema).properties ?? {};
  return Object.entries(example).flatMap(([name, value]) =>
    ['-F', typeof value === 'object' ? quoted(`${name}=${JSON.stringify(value)}`) : `${name}=@${known[name] ? name + '.json' : 'FILE'}`]);
}

/** Returns a command of curl for the operation. `type`: media type of the body, if there is one. `keys`: the server wants tokens. */
function curl({base, method, path, operation, parameters, resolve, keys}, type) {
  const examples = Object.fromEntries(parameters.map(parameter => [parameter.name, parameter.example]));
  const target = path.replace(/\{(\w+)\}/g, (_, name) => encodeURIComponent(examples[name] ?? name));
  const words = ['curl'];
  const answer = resolve(Object.entries(operation.responses).find(([status]) => status.startsWith('2'))?.[1]);
  const types = Object.keys(answer.content ?? {});
  if (types.includes('text/event-stream')) words.push('-N');
  if (types.some(isBinary)) words.push('-o', path.split('/').pop());
  if (method !== 'get' && !(method === 'post' && operation.requestBody)) words.push('-X', method.toUpperCase());
  const open = operation.security?.length === 1 && !Object.keys(operation.security[0]).length;
  if (keys && !open) words.push('-H', '"Authorization: Bearer $TOKEN"');
  if (type) words.push(...bodyWords(type, resolve(operation.requestBody).content[type], resolve));
  return [...words, quoted(base + target.slice(1))].join(' ');
}

function command(text) {
  const code = el('code', {}, text);
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text);
      notify('Copied the command');
    } catch {  // browsers permit this only on a page from this machine or with TLS
      getSelection().selectAllChildren(code);
      notify('The browser does not permit copying. The command is selected: press Ctrl+C');
    }
  };
  return el('div', {class: 'command'}, el('pre', {}, code), button('Copy', copy, {'aria-label': 'Copy: ' + text}));
}

const example = value => el('pre', {class: 'example'}, json(value));

function parameterTable(parameters, resolve) {
  return table('Parameters', ['Name', 'Value', 'Meaning'], parameters.map(parameter => [
    [el('code', {}, parameter.name), ` ${parameter.in}${parameter.required ? '' : ', optional'}`],
    typeNodes(parameter.schema, resolve),
    [...prose(parameter.description), ...(parameter.example === undefined ? []
      : [parameter.description ? '. Example: ' : 'Example: ', el('code', {}, String(parameter.example))])]]));
}

/** Shows the bodies that the operation takes. A form is best shown as a command. */
function requestNodes(shown) {
  const {operation, resolve} = shown;
  return Object.entries(resolve(operation.requestBody).content).flatMap(([type, content]) => {
    const options = resolve(content.schema).properties?.options;
    return [el('p', {class: 'what'}, 'Body: ', el('code', {}, type)),
      ...(content.example === undefined ? [] : [type === 'multipart/form-data' ? command(curl(shown, type)) : example(content.example)]),
      ...(options?.$ref ? [el('p', {}, 'Options: see ', ...typeNodes(options, resolve))] : [])];
  });
}

function responseNodes(responses, resolve) {
  const good = Object.entries(responses).filter(([status]) => status.startsWith('2'));
  const others = Object.keys(responses).filter(status => !status.startsWith('2') && status !== 'default');
  const nodes = good.flatMap(([status, part]) => {
    const answer = resolve(part);
    const contents = Object.entries(answer.content ?? {});
    return [el('p', {class: 'what'}, `Answer ${status}: `, ...prose(answer.description),
      ...contents.flatMap(([type, content]) => [', ', el('code', {}, type),
        ...(content.schema?.$ref ? [', ', ...typeNodes(content.schema, resolve)] : [])])),
      ...contents.filter(([, content]) => content.example !== undefined).map(([, content]) => example(content.example))];
  });
  if (others.length) nodes.push(el('p', {class: 'what'}, `Other answers: ${others.join(', ')}`));
  return nodes;
}

function operationNode(base, path, method, item, resolve, keys) {
  const operation = item[method];
  const parameters = [...item.parameters ?? [], ...operation.parameters ?? []].map(resolve);
  const shown = {base, method, path, operation, parameters, resolve, keys};
  const types = Object.keys(operation.requestBody ? resolve(operation.requestBody).content : {});
  return el('section', {id: operation.operationId, class: 'operation', 'aria-labelledby': 'head-' + operation.operationId},
    el('h3', {id: 'head-' + operation.operationId}, el('span', {class: 'method ' + method}, method.toUpperCase()), ' ', el('code', {}, path)),
    el('p', {}, ...prose(operation.summary)),
    operation.description ? el('p', {}, ...prose(operation.description)) : null,
    command(curl(shown, types[0])),
    parameters.length ? parameterTable(parameters, resolve) : null,
    ...(operation.requestBody ? requestNodes(shown) : []),
    ...responseNodes(operation.responses, resolve));
}

function show(document_, keys) {
  const resolve = resolver(document_);
  const base = new URL('.', document.baseURI).href;
  const operations = Object.entries(document_.paths).flatMap(([path, item]) =>
    methods.filter(method => item[method]).map(method => ({path, item, method, tag: item[method].tags?.[0] ?? 'other'})));
  const tags = [...new Set([...(document_.tags ?? []).map(tag => tag.name), ...operations.map(operation => operation.tag)])];
  const schemas = Object.entries(document_.components?.schemas ?? {}).filter(([, schema]) => schema.properties);
  const link = (href, ...text) => el('li', {}, el('a', {href}, ...text));
  const group = (title, links) => [el('h2', {}, title), el('ul', {}, ...links)];
  document.getElementById('contents').replaceChildren(
    ...tags.flatMap(tag => group(tag, operations.filter(operation => operation.tag === tag).map(({path, item, method}) =>
      link('#' + item[method].operationId, el('span', {class: 'method ' + method}, method.toUpperCase()), ' ', path.replace('/api/v1', ''))))),
    ...group('schemas', schemas.map(([name]) => link('#schema-' + name, name))));
  main.replaceChildren(
    el('h1', {}, 'API'),
    el('p', {}, ...prose(document_.info.description)),
    facts([['Description', el('a', {href: 'api/v1/openapi.json'}, 'OpenAPI ' + document_.openapi)], ['Address', base],
      ['Token', keys ? 'required: in the commands, TOKEN is a variable of the shell' : 'not required']]),
    ...tags.flatMap(tag => [el('h2', {}, tag), ...operations.filter(operation => operation.tag === tag)
      .map(({path, item, method}) => operationNode(base, path, method, item, resolve, keys))]),
    el('h2', {}, 'schemas'),
    ...schemas.map(([name, schema]) => el('section', {id: 'schema-' + name, class: 'operation', 'aria-labelledby': 'head-schema-' + name},
      el('h3', {id: 'head-schema-' + name}, name), el('p', {}, ...prose(schema.description)), propertyTable('Fields', schema, resolve))));
  document.getElementById(location.hash.slice(1))?.scrollIntoView();
}

async function needsToken() {
  try {
    const server = await getJson('server');
    return server.keys ?? server.user !== '';
  } catch (error) {
    return error.status === 401;
  }
}

const theme = localStorage.getItem('parray-theme');
if (theme) document.documentElement.dataset.theme = theme;
try {
  const [description, keys] = await Promise.all([getJson('openapi.json'), needsToken()]);
  show(description, keys);
} catch (error) {
  document.getElementById('reading').textContent = `The description cannot be read: ${error.message}`;
}
