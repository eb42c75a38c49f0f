// What the applications do: the state machine, the tree and the skills of an actuator, the present state lit.
import {get} from './connection.js';
import {chartsWithPresent, joined, neighbourhood, readChart} from './chart_text.js';
import {h} from './dom.js';
import {duration} from './format.js';
import {layOut, pathOf} from './graph_layout.js';
import {t} from './i18n.js';
import {card, commands, levelShape, quoted, shape} from './parts.js';
import {skillsCard} from './skills.js';
import {statusOf} from './store.js';

const KINDS = {behavior_state: 'behavior', tree_state: 'tree'};
const REQUEST_EVERY_MS = 1000;
const MOST_LABELS = 14;
const MOST_STATES = 12;  // of a chart that is drawn whole
const MOST_NODES = 24;   // of a tree that is drawn whole

// [{name, behavior: topic or '', tree: topic or '', skills: bool}], by the topics that are published.
export function applicationsOf(topics, offers) {
  const found = new Map();
  const add = (name, key, value) => found.set(name, {name, behavior: '', tree: '', skills: false,
    ...found.get(name), [key]: value});
  for (const {name, publishers} of topics) {
    const parts = name.split('/');
    const kind = KINDS[parts.at(-1)];
    if (kind && publishers > 0 && parts.length > 1) add(parts.at(-2), kind, name);
  }
  for (const name of Object.keys(offers)) add(name, 'skills', true);
  return [...found.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
}

const skillTopics = topics => topics.filter(({type}) => /^musher_msgs\/msg\/Skill(Offers|Feedback)$/.test(type)).map(({name}) => name);

// ui.reports: by "kind name": {value, error, requestedAt, mark}; requested again when `mark` changes.
function report(ctx, kind, name, mark) {
  const reports = (ctx.ui.reports ??= {});
  const key = `${kind} ${name}`;
  const known = (reports[key] ??= {value: null, error: '', requestedAt: 0, mark: null});
  if (known.mark !== mark && ctx.now - known.requestedAt > REQUEST_EVERY_MS) {
    Object.assign(known, {requestedAt: ctx.now, mark});
    const query = kind === 'behavior' ? {name, format: 'mermaid'} : {name};
    get(`api/${kind}`, query).then(
      value => Object.assign(known, {value, error: value.error ?? ''}),
      error => Object.assign(known, {error: error.message || t('no_answer'), mark: null}),
    ).then(ctx.redraw);
  }
  return known;
}

const layouts = new Map();
function layoutOf(chart, present) {
  const present_id = chart.states.find(s => s.name === present)?.id ?? '';
  const few = chart.arrows.filter(a => a.text).length <= MOST_LABELS;
  const key = JSON.stringify([chart.name, chart.states, chart.arrows, chart.start, few ? '' : present_id]);
  if (!layouts.has(key)) {
    if (layouts.size > 50) layouts.clear();
    const short = text => (text.length > 30 ? `${text.slice(0, 29)}…` : text);
    layouts.set(key, layOut({...chart,
      arrows: chart.arrows.map(a => ({...a, text: few || a.from === present_id ? short(a.text) : ''}))}));
  }
  return layouts.get(key);
}

function arrowHead([x, y], [, fromY]) {
  const down = y >= fromY ? 1 : -1;
  return `M${x.toFixed(1)} ${y.toFixed(1)}l-4.500 ${-8 * down}h9z`;
}

// Scrolls a present state that has changed into the middle of its chart.
function keepInView(ctx, chart, present) {
  const shown = (ctx.ui.charts ??= new Map());
  const one = shown.get(chart.name) ?? {};
  shown.set(chart.name, one);
  const centre = element => {
    const lit = element?.querySelector('.node.lit rect')?.getBoundingClientRect();
    if (!lit) return;
    const box = element.getBoundingClientRect();
    element.scrollLeft += lit.left + lit.width / 2 - box.left - box.width / 2;
    element.scrollTop += lit.top + lit.height / 2 - box.top - box.height / 2;
  };
  const mark = `${present} ${chart.states.length}`;
  if (one.mark !== mark) requestAnimationFrame(() => centre(one.element));
  one.mark = mark;
  return element => {
    one.element = element;
    requestAnimationFrame(() => centre(element));
  };
}

function graph(ctx, chart, present) {
  const laid = layoutOf(chart, present);
  const presentId = chart.states.find(s => s.name === present)?.id;
  const arrows = [...laid.arrows].sort((a, b) => Number(a.from === presentId) - Number(b.from === presentId));
  return h('div', {class: 'graph', key: chart.name, tabindex: '0', role: 'group',
    'aria-label': t('app.graph', {name: chart.name, state: present || '–'}), ref: keepInView(ctx, chart, present)},
  h('svg', {width: laid.width, height: laid.height, viewBox: `0 0 ${laid.width} ${laid.height}`,
    'aria-hidden': 'true'},
    arrows.map(a => h('g', {key: `${a.from} ${a.to} ${a.text}`,
      class: `arrow${a.from === presentId ? ' next' : ''}`},
      h('path', {class: 'line', d: pathOf(a.points)}), h('path',
        {class: 'head', d: arrowHead(a.points.at(-1), a.points.at(-2))}))),
    arrows.map(a => (a.label ? h('text', {key: `text ${a.from} ${a.to} ${a.text}`,
      class: `label${a.from === presentId ? ' next' : ''}`,
      x: a.label.x, y: a.label.y + 4, 'text-anchor': 'middle'}, a.label.text) : null)),
    laid.states.map(s => h('g',
      {key: s.id, class: `node${s.name === present ? ' lit' : ''}${s.safe ? ' safe' : ''}`},
      h('rect', {x: s.x - s.width / 2, y: s.y - s.height / 2, width: s.width, height: s.height,
        rx: s.inside ? 4 : 18}),
      s.final ? h('rect', {class: 'inner', x: s.x - s.width / 2 + 3, y: s.y - s.height / 2 + 3,
        width: s.width - 6, height: s.height - 6, rx: 15}) : null,
      s.id === chart.start ? h('circle', {class: 'start', cx: s.x - s.width / 2 - 8, cy: s.y, r: 4}) : null,
      h('text', {x: s.x, y: s.y + 5, 'text-anchor': 'middle'}, s.name)))));
}

function arrowList(chart) {
  const name = id => chart.states.find(s => s.id === id)?.name ?? id;
  return h('details', null, h('summary', null, t('app.list')), h('ul', {class: 'lines', lang: 'en'},
    chart.arrows.map(a => h('li', null, `${name(a.from)} → ${name(a.to)}`,
      a.text ? h('span', {class: 'quiet'}, `: ${a.text}`) : null))));
}

// A chart, of a large one the neighbourhood of its present state until a person asks for the rest.
function chartPart(ctx, whole, present) {
  const open = (ctx.ui.wholeCharts ??= new Set());
  const {chart, folded} = open.has(whole.name) ? {chart: whole, folded: 0}
    : neighbourhood(whole, present, MOST_STATES);
  const toggle = () => {
    if (!open.delete(whole.name)) open.add(whole.name);
    ctx.redraw();
  };
  return [graph(ctx, joined(chart), present),
    whole.states.length > MOST_STATES ? h('p', {class: 'buttons', key: `fold ${whole.name}`},
      h('button', {class: 'button small', onclick: toggle, 'aria-pressed': String(folded === 0)},
        folded > 0 ? t('app.whole', {count: whole.states.length}) : t('app.near'))) : null,
    arrowList(whole)];
}

// A machine inside of a state: folded while it does not run; one that is at its end says so.
function insidePart(ctx, chart, present) {
  const state = chart.states.find(s => s.name === present);
  if (!state) return h('details', {key: `in ${chart.name}`}, h('summary', null, t('app.inside.off',
    {name: chart.name})), chartPart(ctx, chart, ''));
  return h('div', {key: `in ${chart.name}`}, h('h3', null, chart.name, ' ',
    state.final ? h('span', {class: 'pill tone-ok'}, t('app.finished')) : null), chartPart(ctx, chart, present));
}

// "off in LowPower" of an actuator that answers nothing there; null where it should.
function offText(ctx, name) {
  const actuator = statusOf(ctx.state)?.actuators?.find(a => a.name === name);
  return actuator?.presence === 'present' && actuator.state !== 'Active' ? t('off.in', {state: actuator.state}) : null;
}

function behaviorCard(ctx, app) {
  const live = ctx.state.latest[app.behavior]?.message.data;
  const {value, error} = report(ctx, 'behavior', app.name, live ?? '');
  const present = live ?? value?.current_state ?? '';
  const chart = value ? readChart(value.graph, app.name) : null;
  const state = value?.operating_mode === 'SAFE_STOP' ? 'app.safe' : !present ? 'app.stopped' : value
    && !value.ticking ? 'app.paused' : 'app.running';
  const off = offText(ctx, app.name);
  return card(t('app.machine'), {id: `behavior-${app.name}`, aside: h('span', {class: 'pill'}, value?.ticking ? t(state) : off ?? t(state))},
    h('p', {class: 'present-state'}, present || off || t('app.stopped')),
    error ? h('p', {class: 'reason'}, commands(t('failed', {why: error}))) : null,
    value?.unsafe ? h('p', {class: 'outcome bad'}, levelShape('bad'), quoted(value.unsafe)) : null,
    value?.last_fault ? h('p', {class: 'reason'}, h('b', null, t('app.fault'), ': '),
      quoted(value.last_fault)) : null,
    chart ? chartsWithPresent(chart, present).map(part => part.chart === chart
      ? chartPart(ctx, part.chart, part.present) : insidePart(ctx, part.chart, part.present)) : null,
    value?.history?.length ? [h('h3', null, t('app.changes')),
      h('ol', {class: 'lines changes', lang: 'en'}, value.history.slice(-8).reverse().map(c =>
      h('li', null, h('time', null, duration(c.time_s * 1000)), ` ${c.from || '·'} → ${c.to || '·'} `,
        h('span', {class: 'quiet'}, c.command || c.cause))))] : null);
}

const STATUS_TONES = ['off', 'busy', 'ok', 'bad', 'off'];
const STATUS_SHAPES = ['M8 5a3 3 0 1 0 0 6a3 3 0 0 0 0-6z', 'M3 1.500v13L14 8z',
  'M6.300 13.600L1 8.300l2-2 3.300 3.300L13 2.900l2 2z',
  'M3 1L8 6l5-5 2 2-5 5 5 5-2 2-5-5-5 5-2-2 5-5-5-5z', 'M2 7h12v2H2z'];

function treeNode(nodes, status, id) {
  const node = nodes[id];
  const code = status[id] ?? 0;
  const children = nodes.map((n, i) => (n.parent === id ? i : -1)).filter(i => i >= 0);
  return h('li', {key: id, class: `tree-node s${code}`},
    h('p', null, shape(STATUS_SHAPES[code] ?? STATUS_SHAPES[0], `tone-${STATUS_TONES[code] ?? 'off'}`),
      h('b', null, node.name || node.type),
      node.type !== node.name && node.name ? h('span', {class: 'quiet'}, node.type) : null,
      h('span', {class: `status tone-${STATUS_TONES[code] ?? 'off'}`}, t(`node.${code}`)),
      node.kind === 'Control' || node.kind === 'Decorator' ? null
        : h('span', {class: 'quiet small'}, node.kind)),
    childrenPart(nodes, status, id, children));
}

const sizeOf = (nodes, id) => nodes.reduce((sum, n, i) => sum + (n.parent === id ? 1 + sizeOf(nodes, i) : 0), 0);

// Of a large tree the branches that do not run are folded, and say whether they are finished.
function childrenPart(nodes, status, id, children) {
  if (children.length === 0) return null;
  const list = h('ul', {key: 'list'}, children.map(child => treeNode(nodes, status, child)));
  const code = status[id] ?? 0;
  if (nodes.length <= MOST_NODES || code === 1 || id === 0) return list;
  return h('details', {key: 'folded'}, h('summary', null, t(code === 2 || code === 3 ? 'tree.finished' : 'tree.idle',
    {count: sizeOf(nodes, id)})), list);
}

function treeCard(ctx, app) {
  const live = ctx.state.latest[app.tree]?.message;
  const {value, error} = report(ctx, 'tree', app.name, live?.revision ?? -1);
  const status = live && value && live.revision === value.state.revision ? live.status
    : value?.state.status ?? [];
  const now = live ?? value?.state;
  const fault = now?.last_fault;
  return card(`${t('app.tree')}${now?.tree ? `: ${now.tree}` : ''}`, {id: `tree-${app.name}`,
    aside: now ? h('span', {class: 'pill'}, now.ticking ? t('app.running')
      : offText(ctx, app.name) ?? t('app.paused')) : null},
  error ? h('p', {class: 'reason'}, commands(t('failed', {why: error}))) : null,
  fault ? h('p', {class: 'outcome bad'}, levelShape('bad'), quoted(fault)) : null,
  value?.nodes?.length ? h('ul', {class: 'tree'}, treeNode(value.nodes, status, 0)) : value
    ? h('p', {class: 'quiet'}, t('app.stopped')) : error ? null : h('p', null, offText(ctx, app.name) ?? t('loading')));
}

export function leave(ctx) {
  ctx.watch([]);
}

export function view(ctx) {
  const apps = applicationsOf(ctx.state.topics, ctx.state.offers);
  const app = apps.find(a => a.name === ctx.route.rest[0]) ?? apps[0];
  ctx.watch([...skillTopics(ctx.state.topics), ...(app ? [app.behavior, app.tree].filter(Boolean) : [])]);
  if (!app) return [h('h1', {class: 'hidden'}, t('nav.application')),
    card(t('nav.application'), {}, h('p', {class: 'quiet'}, t('app.none')))];
  return [h('h1', {class: 'hidden'}, t('nav.application')),
    h('div', {class: 'chooser', role: 'group', 'aria-label': t('app.choose')},
      apps.map(a => h('a', {key: a.name, class: 'button',
      href: `#application/${encodeURIComponent(a.name)}`, 'aria-current': a === app ? 'true' : null},
        a.name))),
    h('div', {key: app.name}, app.behavior ? behaviorCard(ctx, app) : null,
      app.tree ? treeCard(ctx, app) : null,
      app.skills ? skillsCard(ctx, app.name) : null)];
}

