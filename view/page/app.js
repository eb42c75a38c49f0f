// Starts the page: the connection feeds the store, and each change of it draws the header and the view
// that the address after '#' names.
import {Connection, get} from './connection.js';
import {draw, h} from './dom.js';
import {duration} from './format.js';
import {confirmDialog} from './confirm.js';
import {language, languageTag, otherLanguage, setLanguage, t} from './i18n.js';
import {releaseButton, stopButton} from './estop.js';
import {loginDialog, logout} from './login.js';
import {batteryBar, commands, docsLink, levelShape, plainText, stateChip, stoppedChip} from './parts.js';
import {apply, freshness, initialState, mayAct, mayStop, recentFaults, statusOf} from './store.js';
import * as actuators from './actuators.js';
import * as application from './application.js';
import * as cameras from './cameras.js';
import * as log from './log.js';
import * as machine from './machine.js';
import * as timeline from './timeline.js';

const ACKNOWLEDGED = 'musher.acknowledged';
const MOST_MACHINES = 32;
const at = id => document.getElementById(id);

function stored(key) {
  try {
    return {...JSON.parse(localStorage.getItem(key))};
  } catch {
    return {};
  }
}

const VIEWS = {robot: machine, actuators, timeline, application, cameras, log};

const ctx = {
  state: initialState(),
  now: Date.now(),
  route: {name: 'robot', rest: []},
  ui: {said: [], alarm: '', acknowledged: stored(ACKNOWLEDGED)},  // what is chosen and open; each view has its own keys
  redraw,
  say(text) {
    ctx.ui.said = [...ctx.ui.said.slice(-4), {text: plainText(text), key: ctx.now + Math.random()}];
    redraw();
  },
  alarm(text) {
    ctx.ui.alarm = text;
    redraw();
  },
  // A person has seen the faults up to `seen`. Other tabs store theirs, too; the newest machine is first.
  acknowledge(seen) {
    const all = {...seen, ...ctx.ui.acknowledged, ...stored(ACKNOWLEDGED), ...seen};
    ctx.ui.acknowledged = Object.fromEntries(Object.entries(all).slice(0, MOST_MACHINES));
    try {
      localStorage.setItem(ACKNOWLEDGED, JSON.stringify(ctx.ui.acknowledged));
    } catch {
      // They come back with the next visit.
    }
    redraw();
  },
  confirm: request => confirmDialog(ctx, at('dialogs'), request),
  focus: id => requestAnimationFrame(() => at(id)?.focus()),
  watch: topics => connection.watch(topics),
  receive: message => onMessage(message),
};

let waiting = 0;
function redraw() {
  if (waiting === 0) waiting = requestAnimationFrame(drawAll);
}

// Says what has changed, for screen readers.
function announceChanges(before, after) {
  const [old, status] = [statusOf(before), statusOf(after)];
  if (!old || !status || old === status) return;
  if (old.state !== status.state) ctx.say(t('title', {name: status.machine, state: status.state}));
  if (!old.emergency_stop && status.emergency_stop) {
    ctx.say(t('stop.engaged'));
  }
  for (const name of (status.degraded ?? []).filter(n => !(old.degraded ?? []).includes(n))) {
    ctx.say(t('problem.degraded', {name}));
  }
}

// A WebSocket does not say why it was not opened; a request does.
function checkWhetherDenied() {
  get('api/topics').then(() => (ctx.ui.denied = false),
    error => (ctx.ui.denied = error.status === 401 || error.status === 403)).then(redraw);
}

function onMessage(message) {
  ctx.now = Date.now();
  const before = ctx.state;
  ctx.state = apply(before, message, ctx.now);
  announceChanges(before, ctx.state);
  if (message.refused) ctx.ui.denied = true;
  else if (message.link === 'closed' && ctx.state.hello === null) checkWhetherDenied();
  if (message.op === 'hello') ctx.ui.denied = false;
  redraw();
}

function toggleLanguage() {
  setLanguage(otherLanguage());
  document.documentElement.lang = languageTag();
  redraw();
}

const faultCount = () => recentFaults(ctx.state, ctx.now, ctx.ui.acknowledged).length;

function headerPart(fresh) {
  const status = statusOf(ctx.state);
  return [
    h('div', {class: 'bar'},
      h('div', {class: 'who'},
        h('span', {class: 'name'}, status?.machine || 'Musher'),
        status ? h('span', {class: 'now'}, status.emergency_stop ? stoppedChip() : null,
          stateChip(status.state)) : null,
        (status?.policy?.active && status.policy.battery >= 0) ? batteryBar(status.policy) : null,
        faultCount() > 0 ? h('a', {class: 'count faults', href: '#robot',
          'aria-label': t('faults.past', {count: faultCount()})}, `! ${faultCount()}`) : null,
        h('span', {class: `link ${fresh}`}, h('i', {'aria-hidden': 'true'}), t(`link.${fresh}`))),
      h('button', {class: 'language', onclick: toggleLanguage,
        'aria-label': t('language.label'),
        lang: language() === 'en' ? 'zh-CN' : 'en'}, t('language')),
      stopButton(ctx)),
    h('nav', {'aria-label': t('nav')}, Object.keys(VIEWS).map(name => h('a', {key: name, href: `#${name}`,
      'aria-current': ctx.route.name === name ? 'page' : null}, t(`nav.${name}`))),
    docsLink()),
  ];
}

function banner(level, key, ...children) {
  return h('div', {class: `banner ${level}`, key}, levelShape(level), h('p', null, children));
}

function oldBanner() {
  const silent = ctx.state.lastReceived ? duration(ctx.now - ctx.state.lastReceived) : '–';
  const rest = ctx.state.link === 'closed' ? Math.ceil((ctx.state.retryAt - ctx.now) / 1000) : 0;
  return h('div', {class: 'banner warn', key: 'old'}, levelShape('warn'),
    h('p', null, t('banner.old', {age: silent}), ' ',
    ctx.state.link === 'connecting' ? t('banner.old.trying') : rest > 0
      ? t('banner.old.retry', {time: `${rest} s`}) : null),
  ctx.state.link === 'closed' ? h('button', {class: 'button small',
    onclick: () => connection.retryNow()},
    t('banner.old.now')) : null);
}

const loginButton = () => h('button', {class: 'button small',
  onclick: () => loginDialog(ctx, at('dialogs'))}, t('login'));

function banners(fresh) {
  const status = statusOf(ctx.state);
  return [
    ctx.ui.alarm ? h('div', {class: 'banner bad', key: 'alarm', role: 'alert'}, levelShape('bad'),
      h('p', null, commands(ctx.ui.alarm)),
      h('button', {class: 'button small', onclick: () => ctx.alarm('')}, t('close'))) : null,
    status?.emergency_stop ? h('div', {class: 'banner bad', key: 'stop', role: 'alert'}, levelShape('bad'),
      h('p', null, h('b', null, t('stop.engaged')), ' ',
      commands(t('stop.by', {by: status.emergency_stop_by || '?', reason: status.emergency_stop_reason})),
      status.stop_ids?.length > 1 ? ` ${t('stop.more', {count: status.stop_ids.length})}` : null),
      releaseButton(ctx)) : null,
    ctx.ui.denied ? h('div', {class: 'banner warn', key: 'denied'}, levelShape('warn'),
      h('p', null, commands(t('banner.denied'))), loginButton()) : fresh === 'old' ? oldBanner() : null,
    fresh === 'gone' ? banner('bad', 'gone', commands(t('banner.gone'))) : null,
    fresh === 'waiting' ? banner('warn', 'waiting', commands(t('banner.waiting'))) : null,
    ctx.state.hello && !mayAct(ctx.state)
      ? h('div', {class: 'banner plain', key: 'look'}, h('p', {id: 'look-how'}, h('b', null, t('look.only')),
        ' ', commands(t('look.how')), ' ', mayStop(ctx.state) ? t('stop.free') : commands(t('stop.also'))),
        loginButton()) : null,
    mayAct(ctx.state)
      ? h('div', {class: 'banner plain', key: 'act'}, h('p', null,
        t('look.as', {who: ctx.state.hello.who || '?'})),
        h('button', {class: 'link-button', onclick: () => logout(ctx, false)}, t('logout')),
        h('button', {class: 'link-button', onclick: () => logout(ctx, true)}, t('logout.all')))
      : null,
  ];
}

function drawAll() {
  waiting = 0;
  ctx.now = Date.now();
  const fresh = freshness(ctx.state, ctx.now);
  const status = statusOf(ctx.state);
  const faults = faultCount() > 0 ? `(${faultCount()}) ` : '';
  const state = status?.emergency_stop ? t('stopped.big') : status?.state;
  document.title = status ? `${faults}${t('title', {name: status.machine, state})} – Musher` : 'Musher';
  document.body.classList.toggle('dead', fresh !== 'live' && fresh !== 'connecting');
  if (fresh !== ctx.ui.fresh && ctx.ui.fresh && fresh !== 'connecting') ctx.say(t(`link.${fresh}`));
  ctx.ui.fresh = fresh;
  at('skip').textContent = t('skip');
  draw(at('top'), headerPart(fresh));
  at('banners').setAttribute('aria-label', t('banner.label'));
  draw(at('banners'), banners(fresh));
  draw(at('main'), VIEWS[ctx.route.name].view(ctx));
  draw(at('said'), ctx.ui.said.map(said => h('p', {key: said.key}, said.text)));
}

function readRoute() {
  const [name, ...rest] = location.hash.replace(/^#\/?/, '').split('/').map(part => {
    try {
      return decodeURIComponent(part);
    } catch {
      return part;
    }
  });
  const before = ctx.route.name;
  if (name === 'main') return;  // of the skip link
  ctx.route = {name: name in VIEWS ? name : 'robot', rest};
  if (before !== ctx.route.name) {
    VIEWS[before].leave?.(ctx);
    scrollTo(0, 0);
    ctx.focus('main');
  }
  VIEWS[ctx.route.name].enter?.(ctx);
  redraw();
}

document.documentElement.lang = languageTag();
const connection = new Connection(onMessage);
addEventListener('hashchange', readRoute);
document.addEventListener('visibilitychange', () => document.hidden || connection.retryNow());
at('skip').addEventListener('click', event => {
  event.preventDefault();
  at('main').focus();
});
setInterval(redraw, 1000);  // ages grow without messages
readRoute();
