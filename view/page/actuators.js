// Every actuator: its state, health, process and reason; opened, also the end of its log and a restart.
import {get, post} from './connection.js';
import {h} from './dom.js';
import {bytes, percent} from './format.js';
import {t} from './i18n.js';
import {actButton, card, codeNote, commands, facts, levelShape, lookHint, quoted, shape, stateChip} from './parts.js';
import {shownMachine, statusOf} from './store.js';

const TAIL_BYTES = 4000;
const TAIL_EVERY_MS = 2000;

// The health as a person sees it: what is worst counts.
export function healthOf(a) {
  if (a.restarting) return ['restarting', 'warn'];
  if (a.health !== 'well') return [a.health, a.health === 'starved' ? 'warn' : 'bad'];
  if (a.presence === 'lost') return ['lost', 'bad'];
  if (a.presence === 'absent') return ['absent', a.degraded ? 'bad' : 'off'];
  if (a.presence === 'starting') return ['starting', 'busy'];
  if (a.degraded) return ['degraded', 'warn'];
  return ['well', 'ok'];
}

export function healthMark(a) {
  const [name, tone] = healthOf(a);
  const mark = {ok: 'ok', warn: 'warn', bad: 'bad'}[tone];
  return h('span', {class: 'health'}, mark ? levelShape(mark) : shape('M2 7h12v2H2z', `tone-${tone}`),
    t(`health.${name}`));
}

async function readTail(ctx, name) {
  const tail = ctx.ui.tail;
  tail.requestedAt = ctx.now;
  try {
    const answer = await get('api/log', {actuator: name, from: -TAIL_BYTES});
    tail.text = answer.from > 0 ? answer.text.slice(answer.text.indexOf('\n') + 1) : answer.text;
    tail.error = '';
  } catch (error) {
    tail.error = error.message || t('no_answer');
  }
  ctx.redraw();
}

function tailPart(ctx, name) {
  if (ctx.ui.tail?.name !== name) ctx.ui.tail = {name, text: null, error: '', requestedAt: 0};
  if (ctx.now - ctx.ui.tail.requestedAt > TAIL_EVERY_MS) readTail(ctx, name);
  const {text, error} = ctx.ui.tail;
  return h('div', {class: 'tail'},
    h('div', {class: 'card-head'}, h('h3', {id: 'tail-title'}, t('log.tail')),
      h('a', {href: `#log/${encodeURIComponent(name)}`}, t('log.whole'))),
    error ? h('p', {class: 'quiet'}, commands(t('log.none', {why: error})))
      : text === '' ? h('p', {class: 'quiet'}, t('log.empty'))
        : h('pre', {tabindex: '0', lang: 'en', role: 'group', 'aria-labelledby': 'tail-title'},
          text === null ? t('loading') : text.trimEnd().split('\n').slice(-12).join('\n')));
}

async function restart(ctx, a) {
  const shown = shownMachine(ctx.state);
  const yes = await ctx.confirm({title: t('restart.title', {name: a.name}),
    text: t('restart.text') + (a.critical ? ` ${t('restart.critical')}` : ''), yes: t('restart.yes'),
      no: t('cancel')});
  if (!yes) return;
  let why = '';
  try {
    const answer = await post('api/restart', {...shown, actuator: a.name});
    if (answer.code) why = answer.reason || t('code', {code: answer.code});
  } catch (error) {
    why = error.message || t('no_answer');
  }
  if (why) ctx.alarm(t('restart.failed', {name: a.name, why}));
  else ctx.say(t('restart.done', {name: a.name}));
}

function detailRow(ctx, a, columns) {
  const process = ctx.state.processes[a.name];
  return h('tr', {key: `${a.name}-details`, class: 'details-row'}, h('td', {colspan: columns},
    h('div', {class: 'details'},
      facts([
        a.message ? [t('reason'), quoted(a.message), codeNote(a.message, a.code)] : null,
        a.critical ? [t('critical'), t('critical.text')] : null,
        [t('pid'), a.pid ? String(a.pid) : '–'],
        process ? [t('threads'), String(process.threads)] : null,
        [t('protocol'), a.protocol],
        [t('stage'), String(a.stage)],
        [t('host'), h('code', null, a.host || '–')],
      ]),
      h('p', {class: 'buttons'}, actButton(ctx, t('restart'), () => restart(ctx, a),
        {label: t('restart.title', {name: a.name})}),
        h('a', {class: 'button', href: `#timeline/why/${encodeURIComponent(a.name)}`}, t('why'))),
      lookHint(ctx), tailPart(ctx, a.name))));
}

const COLUMNS = 7;

function row(ctx, a) {
  const open = ctx.ui.openActuator === a.name;
  const process = ctx.state.processes[a.name];
  const label = name => ({'data-label': name});
  return [h('tr', {key: a.name, class: `actuator ${healthOf(a)[1]}`},
    h('th', {scope: 'row'}, h('button', {class: 'opener', 'aria-expanded': String(open),
      id: `actuator-${a.name}`,
      onclick: () => {
        ctx.ui.openActuator = open ? '' : a.name;
        ctx.redraw();
      }}, shape('M5 2l6 6-6 6z', open ? 'turn open' : 'turn'), a.name),
    a.critical ? h('span', {class: 'pill'}, t('critical')) : null,
    a.held ? h('span', {class: 'pill tone-warn'}, t('held')) : null),
    h('td', label(t('state')), a.presence === 'present' ? stateChip(a.state) : stateChip(a.presence),
      a.target && a.target !== a.state ? [' → ', stateChip(a.target)] : null),
    h('td', label(t('health')), healthMark(a)),
    h('td', {...label(t('pid')), class: 'number'}, a.pid || '–'),
    h('td', {...label(t('cpu')), class: 'number'}, process ? percent(process.cpu_percent) : '–'),
    h('td', {...label(t('memory')), class: 'number'}, process ? bytes(process.rss_bytes) : '–'),
    h('td', {...label(t('restarts')), class: 'number'}, a.restarts)),
  a.message && !open ? h('tr', {key: `${a.name}-why`, class: 'why-row'},
    h('td', {colspan: COLUMNS}, quoted(a.message))) : null,
  open ? detailRow(ctx, a, COLUMNS) : null];
}

export function enter(ctx) {
  const [name] = ctx.route.rest;
  if (!name) return;
  ctx.ui.openActuator = name;
  ctx.focus(`actuator-${name}`);
}

export function view(ctx) {
  const status = statusOf(ctx.state);
  const list = status?.actuators ?? [];
  return [h('h1', {class: 'hidden'}, t('nav.actuators')), card(t('nav.actuators'), {id: 'actuators-title'},
    h('p', {class: 'quiet'}, t('actuators.intro')),
    status === null ? h('p', null, t('loading')) : h('table',
      {class: 'actuators', 'aria-labelledby': 'actuators-title'},
      h('thead', null, h('tr', null, ['actuator', 'state', 'health', 'pid', 'cpu', 'memory',
        'restarts'].map((name, i) =>
        h('th', {scope: 'col', key: name, class: i > 2 ? 'number' : ''}, t(name))))),
      h('tbody', null, list.map(a => row(ctx, a)))))];
}
