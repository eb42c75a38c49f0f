// The states of the robot and of each actuator over time, faults as marks, and why they happened.
import {get} from './connection.js';
import {h} from './dom.js';
import {clock, day, when} from './format.js';
import {t} from './i18n.js';
import {card, levelShape, toneOf} from './parts.js';
import {plotsCard, plotTopics} from './plots.js';
import {robotNow, statusOf} from './store.js';
import {lanesOf, panned, spansOf, ticks, zoomed} from './timeline_model.js';
import {eventRow, eventToExplain, whyPanel} from './why.js';

const MOST_ROWS = 100;
const OLDER = 4000;
const FIRST_MS = 15 * 60e3;

// ui.time: {length, to}; `to` is null while the chart follows the present. ui.width: of the chart, in px.
function windowOf(ctx) {
  const time = (ctx.ui.time ??= {length: FIRST_MS, to: null});
  const to = time.to ?? robotNow(ctx.state, ctx.now) + time.length * 0.02;
  return {from: to - time.length, to};
}

function show(ctx, window) {
  const now = robotNow(ctx.state, ctx.now);
  const length = window.to - window.from;
  const follows = window.to >= now && window.to <= now + length * 0.3 && ctx.ui.time.to === null;
  ctx.ui.time = {length, to: follows ? null : Math.min(window.to, now + length * 0.5)};
  ctx.redraw();
}

const zoom = (ctx, factor, at) => {
  const window = windowOf(ctx);
  const follows = ctx.ui.time.to === null;
  if (follows && at === undefined) {
    ctx.ui.time = {length: zoomed(window, factor, window.to).to - zoomed(window, factor, window.to).from,
      to: null};
    return ctx.redraw();
  }
  show(ctx, zoomed(window, factor, at ?? (window.from + window.to) / 2));
};

function pan(ctx, share) {
  const window = windowOf(ctx);
  const now = robotNow(ctx.state, ctx.now);
  const next = panned(window, share);
  ctx.ui.time = {length: next.to - next.from, to: share > 0 && next.to > now ? null : next.to};
  ctx.redraw();
}

function toNow(ctx) {
  ctx.ui.time = {...ctx.ui.time, to: null};
  ctx.redraw();
}

function toAll(ctx) {
  const first = ctx.state.history[0]?.ms;
  if (first === undefined) return;
  ctx.ui.time = {length: Math.max(1000, (robotNow(ctx.state, ctx.now) - first) * 1.04), to: null};
  ctx.redraw();
}

function geometry(ctx) {
  const width = ctx.ui.width || 800;
  const narrow = width < 560;
  return {width, narrow, left: narrow ? 0 : 132, lane: narrow ? 42 : 28, bar: 20, top: 24};
}

let memo = {};
function lanes(ctx) {
  const {history, observed} = ctx.state;
  const names = (statusOf(ctx.state)?.actuators ?? []).map(a => a.name);
  const key = names.join(' ');
  if (memo.history !== history || memo.observed !== observed || memo.key !== key) {
    memo = {history, observed, key, value: lanesOf(history, observed, names)};
  }
  return memo.value;
}

// Spans shorter than a pixel, in a pixel that has one, are left out.
function visible(spans, x, g) {
  let last = -1;
  return spans.filter(span => {
    const [from, to] = [x(span.from), x(span.to)];
    if (to <= g.left || from >= g.width) return false;
    const short = to - from < 1;
    if (short && Math.floor(from) === last) return false;
    last = Math.floor(to);
    return true;
  });
}

function spanPart(span, x, y, g) {
  const from = Math.max(g.left, x(span.from));
  const to = Math.min(g.width, x(span.to));
  const width = Math.max(1, to - from);
  const label = width > span.state.length * 7.4 + 10;
  return h('g', {class: `span fill-${toneOf(span.state)}`},
    h('rect', {x: from, y, width, height: g.bar, rx: 3}),
    label ? h('text', {x: from + 6, y: y + 14}, span.state) : null);
}

// Of marks closer than 6 px only the worst, so that a crash loop stays readable and fast.
function markParts(marks, x, y, g) {
  const places = new Map();
  for (const mark of marks) {
    const at = x(mark.ms);
    if (at < g.left || at > g.width) continue;
    const place = Math.round(at / 6);
    if (places.get(place)?.mark.level !== 'bad') places.set(place, {mark, at});
  }
  return [...places.values()].map(({mark, at}) => {
    const shapeOf = mark.level === 'bad' ? `M${at} ${y + 1}l8.500 16h-17z` : `M${at} ${y + 1}l8 8l-8 8l-8-8z`;
    return h('path', {class: `mark ${mark.level}`, d: shapeOf});
  });
}

function lanePart(lane, i, ctx, x, g, now) {
  const y = g.top + i * g.lane + (g.narrow ? 18 : 4);
  return h('g', {key: lane.name || '(robot)'},
    h('text', {class: `lane-name${i === 0 ? ' first' : ''}`, x: 0, y: g.narrow ? y - 5 : y + 14},
      lane.name || t('timeline.machine')),
    h('rect', {class: 'lane-ground', x: g.left, y, width: Math.max(0, g.width - g.left), height: g.bar,
      rx: 3}),
    visible(spansOf(lane.changes, now), x, g).map(span => spanPart(span, x, y, g)),
      markParts(lane.marks, x, y, g));
}

function axisPart(window, x, g, height) {
  const {step, list} = ticks(window.from, window.to, Math.max(2, Math.floor((g.width - g.left) / 92)));
  return list.map(at => h('g', {class: 'tick'}, h('line', {x1: x(at), x2: x(at), y1: 18, y2: height}),
    h('text', {x: Math.min(x(at), g.width - 30), y: 12, 'text-anchor': 'middle'}, step >= 86400e3 ? day(at)
      : step < 1000 ? `${clock(at)}.${String(at % 1000).padStart(3, '0').slice(0, 1)}` : clock(at))));
}

// The event that a click means: a mark near it in that lane, else the last event before it.
function eventAt(ctx, px, py) {
  const g = geometry(ctx);
  const window = windowOf(ctx);
  const all = lanes(ctx).lanes;
  const lane = all[Math.floor((py - g.top) / g.lane)];
  if (!lane) return null;
  const perPx = (window.to - window.from) / (g.width - g.left);
  const ms = window.from + (px - g.left) * perPx;
  const near = lane.marks.filter(mark => Math.abs(mark.ms - ms) < 12 * perPx)
    .sort((a, b) => Math.abs(a.ms - ms) - Math.abs(b.ms - ms))[0];
  if (near) return near.entry;
  return ctx.state.history.findLast(e => e.ms <= ms && (lane.name ? e.actuator === lane.name
    : e.state !== '')) ?? null;
}

function choose(entry) {
  if (entry) location.hash = `timeline/${entry.epoch}/${entry.id}`;
}

// Wheel, drag, touch and keys of the chart.
function connect(ctx, element) {
  new ResizeObserver(() => {
    if (ctx.ui.width === element.clientWidth) return;
    ctx.ui.width = element.clientWidth;
    ctx.redraw();
  }).observe(element);
  const timeAt = px => {
    const g = geometry(ctx);
    const window = windowOf(ctx);
    return window.from + ((px - g.left) / (g.width - g.left)) * (window.to - window.from);
  };
  const left = () => element.getBoundingClientRect().left;
  element.addEventListener('wheel', event => {
    event.preventDefault();
    const g = geometry(ctx);
    if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) pan(ctx, event.deltaX / (g.width - g.left));
    else show(ctx, zoomed(windowOf(ctx), Math.exp(event.deltaY * 0.0015), timeAt(event.clientX - left())));
  }, {passive: false});
  let drag = null;
  element.addEventListener('pointerdown', event => {
    if (event.button !== 0) return;
    drag = {x: event.clientX, moved: false, window: windowOf(ctx)};
    element.setPointerCapture(event.pointerId);
  });
  element.addEventListener('pointermove', event => {
    if (!drag) return;
    const by = event.clientX - drag.x;
    if (Math.abs(by) > 4) drag.moved = true;
    const g = geometry(ctx);
    if (drag.moved) {
      const next = panned(drag.window, -by / (g.width - g.left));
      ctx.ui.time = {length: next.to - next.from, to: next.to};
      ctx.redraw();
    }
  });
  element.addEventListener('pointerup', event => {
    const box = element.getBoundingClientRect();
    if (drag && !drag.moved) choose(eventAt(ctx, event.clientX - box.left, event.clientY - box.top));
    drag = null;
  });
  element.addEventListener('pointercancel', () => (drag = null));
}

function onKey(ctx, event) {
  const actions = {ArrowLeft: () => pan(ctx, -0.2), ArrowRight: () => pan(ctx, 0.2),
    '+': () => zoom(ctx, 0.6), '=': () => zoom(ctx, 0.6),
    '-': () => zoom(ctx, 1.6), End: () => toNow(ctx), Home: () => toAll(ctx)};
  const action = actions[event.key];
  if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  action();
}

function chart(ctx) {
  const g = geometry(ctx);
  const window = windowOf(ctx);
  const now = robotNow(ctx.state, ctx.now);
  const {lanes: all, stops} = lanes(ctx);
  const height = g.top + all.length * g.lane + 4;
  const x = ms => g.left + ((ms - window.from) / (window.to - window.from)) * (g.width - g.left);
  return h('div', {class: 'chart', key: 'chart', id: 'chart', tabindex: '0', role: 'group',
    'data-length': Math.round(window.to - window.from), 'data-to': ctx.ui.time.to ?? 'now',
    'aria-label': t('timeline.chart'),
    onkeydown: event => onKey(ctx, event), ref: element => connect(ctx, element)},
  h('svg', {width: g.width, height, viewBox: `0 0 ${g.width} ${height}`, 'aria-hidden': 'true'},
    axisPart(window, x, g, height),
    stops.map(stop => {
      const from = Math.max(g.left, x(stop.from));
      const to = Math.min(g.width, x(stop.to ?? now));
      return to > from ? h('rect', {class: 'stop-time', x: from, y: g.top, width: Math.max(2, to - from),
        height: height - g.top}) : null;
    }),
    all.map((lane, i) => lanePart(lane, i, ctx, x, g, now)),
    x(now) <= g.width ? h('line', {class: 'present', x1: x(now), x2: x(now), y1: 18, y2: height}) : null));
}

function controls(ctx) {
  const button = (name, text, action) => h('button', {key: name, class: 'button small',
    'aria-label': t(`timeline.${name}`),
    title: t(`timeline.${name}`), onclick: action}, text);
  return h('div', {class: 'chart-controls', role: 'group', 'aria-label': t('nav.timeline')},
    button('back', '←', () => pan(ctx, -0.3)), button('forward', '→', () => pan(ctx, 0.3)),
    button('in', '+', () => zoom(ctx, 0.5)), button('out', '−', () => zoom(ctx, 2)),
    button('all', t('timeline.all'), () => toAll(ctx)),
    h('button', {key: 'live', class: 'button small',
      'aria-pressed': String(ctx.ui.time?.to === null),
      onclick: () => toNow(ctx)}, t('timeline.live')));
}

function legend() {
  return h('p', {class: 'legend quiet small'}, t('timeline.legend'), ' ', levelShape('bad'),
    ` ${t('timeline.fault')} `,
    levelShape('warn'), ` ${t('level.warn')} `, h('span', {class: 'stop-sample', 'aria-hidden': 'true'}),
      ` ${t('timeline.stop')}`);
}

function eventsCard(ctx, chosen) {
  const window = windowOf(ctx);
  const of = ctx.ui.eventsOf ?? '*';
  const faults = ctx.ui.onlyFaults === true;
  const found = ctx.state.history.filter(entry => entry.ms >= window.from && entry.ms <= window.to
    && (of === '*' || entry.actuator === of) && (!faults || ['bad', 'warn'].includes(levelOf(entry))));
  const list = found.slice(-MOST_ROWS).reverse();
  const names = (statusOf(ctx.state)?.actuators ?? []).map(a => a.name);
  return card(t('timeline.events'), {id: 'events-title'},
    h('div', {class: 'filters'},
      h('label', {for: 'events-of'}, t('timeline.of')),
      h('select', {id: 'events-of', value: of, onchange: event => {
        ctx.ui.eventsOf = event.target.value;
        ctx.redraw();
      }}, h('option', {value: '*', key: '*'}, t('timeline.everything')),
        h('option', {value: '', key: ''}, t('timeline.machine')),
      names.map(name => h('option', {value: name, key: name}, name))),
      h('label', {class: 'check'}, h('input', {type: 'checkbox', onchange: event => {
        ctx.ui.onlyFaults = event.target.checked;
        ctx.redraw();
      }}), t('timeline.faults'))),
    list.length === 0 ? h('p', {class: 'quiet'}, t('timeline.none'))
      : h('ol', {class: 'events'}, list.map(entry => eventRow(entry,
        {time: when(entry.ms, ctx.now), open: entry === chosen}))),
    found.length > list.length ? h('p', {class: 'quiet'},
      t('timeline.more', {count: list.length, all: found.length})) : null);
}

function chosenEntry(ctx) {
  const [first, second] = ctx.route.rest;
  if (first === undefined) return null;
  if (first === 'why') return eventToExplain(ctx.state.history, second ?? '');
  return ctx.state.history.find(e => String(e.epoch) === first && String(e.id) === second) ?? null;
}

// The server sends the newest entries by itself; the earlier ones are fetched once.
async function fetchOlder(ctx) {
  if (ctx.ui.older || ctx.state.history.length === 0) return;
  ctx.ui.older = true;
  try {
    const answer = await get('api/history', {limit: OLDER});
    const entries = (answer.entries ?? []).map((entry, i) => ({event: answer.events?.[i], ...entry}));
    ctx.receive({op: 'older', entries});
  } catch {
    // What is there stays; a chain of causes says that it is incomplete.
  }
}

export function enter(ctx) {
  if (ctx.route.rest.length) ctx.focus('why');
}

export function leave(ctx) {
  ctx.watch([]);
}

export function view(ctx) {
  fetchOlder(ctx);
  ctx.watch(plotTopics(ctx));
  const chosen = chosenEntry(ctx);
  return [h('h1', {class: 'hidden'}, t('nav.timeline')),
    card(t('nav.timeline'), {id: 'timeline-title', aside: controls(ctx)},
      h('p', {class: 'quiet'}, t('timeline.intro')), chart(ctx), legend()),
    chosen ? whyPanel(ctx.state.history, chosen, () => {
      location.hash = 'timeline';
      ctx.focus('chart');
    }) : null,
    plotsCard(ctx, windowOf(ctx), geometry(ctx)),
    eventsCard(ctx, chosen)];
}
