// Draws descriptions of elements, and changes only what differs: the focus, the
// scroll position and an opened <details> stay. Data becomes text nodes and attributes, never HTML.

const SVG = 'http://www.w3.org/2000/svg';
const SVG_TAGS = new Set(
  ['svg', 'g', 'path', 'rect', 'circle', 'line', 'text', 'tspan', 'polygon', 'title', 'defs', 'marker',
    'clipPath']);

// h('p', {class: 'quiet', onclick: f, key: 'k', style: {width: '3px'}, ref: element => {}}, 'text', h(...))
export function h(tag, props, ...children) {
  const kept = children.flat(Infinity).filter(c => c !== null && c !== undefined && c !== false && c !== '');
  return {
    tag,
    props: tag === 'button' ? {type: tag, ...props} : props ?? {},
    key: props?.key,
    children: kept.map(c => (typeof c === 'object' ? c : {tag: '#text', text: String(c)})),
  };
}

function setProp(element, name, value, before) {
  if (name === 'key' || name === 'ref' || value === before) return;
  if (name.startsWith('on')) {
    element[name] = value ?? null;
  } else if (name === 'style') {
    for (const [property, text] of Object.entries(value ?? {})) {
      if (before?.[property] !== text) element.style.setProperty(property, text);
    }
  } else if (name === 'value') {
    if (element.value !== value) element.value = value;
  } else if (value === null || value === undefined || value === false) {
    element.removeAttribute(name);
  } else {
    element.setAttribute(name, value === true ? '' : String(value));
  }
}

function make(node, inSvg) {
  if (node.tag === '#text') {
    node.element = document.createTextNode(node.text);
    return node.element;
  }
  const svg = node.tag === 'svg' || (inSvg && SVG_TAGS.has(node.tag));
  const element = svg ? document.createElementNS(SVG, node.tag) : document.createElement(node.tag);
  node.element = element;
  for (const [name, value] of Object.entries(node.props)) {
    if (name !== 'value') setProp(element, name, value, undefined);
  }
  renderInto(element, node.children, [], svg);
  if ('value' in node.props) setProp(element, 'value', node.props.value, undefined);
  node.props.ref?.(element);
  return element;
}

function update(before, node) {
  node.element = before.element;
  if (node.tag === '#text') {
    if (before.text !== node.text) node.element.data = node.text;
    return;
  }
  for (const name of Object.keys(before.props)) {
    if (!(name in node.props)) setProp(node.element, name, undefined, before.props[name]);
  }
  for (const [name, value] of Object.entries(node.props)) {
    setProp(node.element, name, value, before.props[name]);
  }
  renderInto(node.element, node.children, before.children, node.element.namespaceURI === SVG);
}

function renderInto(parent, next, before, inSvg) {
  const keyed = new Map();
  const unkeyed = [];
  for (const node of before) {
    if (node.key !== undefined) keyed.set(node.key, node);
    else unkeyed.push(node);
  }
  const used = new Set();
  let position = 0;
  for (const node of next) {
    const old = node.key !== undefined ? keyed.get(node.key) : unkeyed[position++];
    if (old && old.tag === node.tag && !used.has(old)) {
      used.add(old);
      update(old, node);
    } else {
      make(node, inSvg);
    }
  }
  for (const node of before) if (!used.has(node)) node.element.remove();
  let place = parent.firstChild;
  for (const node of next) {
    if (node.element === place) place = place.nextSibling;
    else parent.insertBefore(node.element, place);
  }
}

// Draws `children` as the whole content of `parent`.
export function draw(parent, children) {
  const next = h('x', null, children).children;
  if (parent.drawn === undefined) parent.replaceChildren();
  renderInto(parent, next, parent.drawn ?? [], false);
  parent.drawn = next;
}
