// Plots of numbers over the time that the timeline shows: battery, switch times, CPU and memory of an actuator, and
// each number of a topic. ui.plots: their ids. ui.plotTopic: the topic whose numbers are offered.
import {h} from './dom.js';
import {bytes, duration, percent} from './format.js';
import {t} from './i18n.js';
import {card} from './parts.js';
import {shownOf, numbersOf, switchTimes} from './plots_model.js';
import {robotNow, statusOf} from './store.js';

const HEIGHT = 72;
const SWITCHES = 'switches';
const NO_NUMBERS = /\/(Image|CompressedImage|PointCloud2)$/;

const plain = value => String(Number(value.toPrecision(5)));
const FORMATS = {battery: percent, cpu: percent, memory: bytes, switches: duration};
const formatOf = id => FORMATS[id.split(' ')[0]] ?? plain;

export const plotted = ctx => (ctx.ui.plots ??= ['battery', SWITCHES]);

// "/imu linear.x" is of the topic /imu.
const topicOf = id => (id.startsWith('/') ? id.split(' ')[0] : null);

// The topics that are to be received for the plots.
export const plotTopics = ctx => [...new Set([...plotted(ctx).map(topicOf), ctx.ui.plotTopic])].filter(Boolean);

function nameOf(id) {
  const [kind, ...rest] = id.split(' ');
  return kind in FORMATS ? [t(`plots.${kind}`), ...rest].join(' ') : id;
}

function change(ctx, ids) {
  ctx.ui.plots = ids;
  ctx.receive({op: 'plot', ids});
}

// A value holds until the next one; a time that something took is a bar.
function pathOf(id, {points, least, most}, x, now, g) {
  const [low, high] = id === SWITCHES ? [0, most || 1] : most > least ? [least, most] : [least - 1, most + 1];
  const y = value => (HEIGHT - 4 - ((value - low) / (high - low)) * (HEIGHT - 8)).toFixed(1);
  const at = ms => Math.min(g.width, Math.max(g.left, x(ms))).toFixed(1);
  if (id === SWITCHES) return points.map(p => `M${at(p.ms)} ${HEIGHT - 4}V${y(p.value)}`).join('');
  const steps = points.map((p, i) => `${i ? 'H' : 'M'}${at(p.ms)}${i ? 'V' : ' '}${y(p.value)}`);
  return `${steps.join('')}H${at(now)}`;
}

function plotPart(ctx, id, points, window, g) {
  const format = formatOf(id);
  const now = Math.min(window.to, robotNow(ctx.state, ctx.now));
  const x = ms => g.left + ((ms - window.from) / (window.to - window.from)) * (g.width - g.left);
  const shown = shownOf(points, {from: window.from, to: now});
  const name = nameOf(id);
  return h('li', {key: id, class: 'plot'},
    h('p', {class: 'plot-head'}, h('b', null, name), ' ', shown
      ? [h('span', {class: 'number'}, format(shown.last)), ' ', h('span', {class: 'quiet small'},
        t('plots.range', {least: format(shown.least), most: format(shown.most)}))]
      : h('span', {class: 'quiet small'}, t('plots.none')),
    h('button', {class: 'button small', 'aria-label': t('plots.remove', {name}),
      onclick: () => change(ctx, plotted(ctx).filter(other => other !== id))}, '✕')),
    shown ? h('svg', {width: g.width, height: HEIGHT, viewBox: `0 0 ${g.width} ${HEIGHT}`, 'aria-hidden': 'true'},
      h('rect', {class: 'lane-ground', x: g.left, y: 0, width: Math.max(0, g.width - g.left), height: HEIGHT, rx: 3}),
      h('path', {class: 'plot-line', d: pathOf(id, shown, x, now, g)})) : null);
}

function choice(ctx) {
  const names = (statusOf(ctx.state)?.actuators ?? []).map(a => a.name);
  const ids = ['battery', SWITCHES, ...names.map(name => `cpu ${name}`), ...names.map(name => `memory ${name}`)];
  const topics = ctx.state.topics.filter(topic => !NO_NUMBERS.test(topic.type)).map(topic => topic.name).sort();
  const topic = ctx.ui.plotTopic ?? '';
  const fields = Object.keys(numbersOf(ctx.state.latest[topic]?.message)).map(field => `${topic} ${field}`);
  const add = event => {
    if (event.target.value) change(ctx, [...plotted(ctx), event.target.value]);
  };
  const picker = (id, list, first) => h('select', {id, value: '', onchange: add},
    h('option', {key: '', value: ''}, first),
    list.filter(one => !plotted(ctx).includes(one)).map(one => h('option', {key: one, value: one}, nameOf(one))));
  return h('div', {class: 'filters'},
    h('label', {for: 'plot-add'}, t('plots.add')), picker('plot-add', ids, '–'),
    h('label', {for: 'plot-topic'}, t('plots.topic')),
    h('select', {id: 'plot-topic', value: topic, onchange: event => {
      ctx.ui.plotTopic = event.target.value;
      ctx.redraw();
    }}, h('option', {key: '', value: ''}, '–'), topics.map(name => h('option', {key: name, value: name}, name))),
    topic ? [h('label', {for: 'plot-field'}, t('plots.field')),
      picker('plot-field', fields, fields.length ? '–' : t('plots.none'))] : null);
}

// `window` and `g`: the time and the geometry of the timeline.
export function plotsCard(ctx, window, g) {
  const points = id => (id === SWITCHES ? switchTimes(ctx.state.history) : ctx.state.numbers[id] ?? []);
  return card(t('plots'), {id: 'plots-title'}, h('p', {class: 'quiet'}, t('plots.intro')), choice(ctx),
    h('ul', {class: 'plots'}, plotted(ctx).map(id => plotPart(ctx, id, points(id), window, g))));
}
