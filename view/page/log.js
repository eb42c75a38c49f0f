// The logs of actuators and of the controller, one or several as one by time: their ends are followed, earlier
// parts are read on request. The address names them: #log/controller,audio.
import {get} from './connection.js';
import {h} from './dom.js';
import {bytes} from './format.js';
import {t} from './i18n.js';
import {chosenLines, LEVELS, merged, readLines} from './log_lines.js';
import {card, commands} from './parts.js';
import {statusOf} from './store.js';

const PART_BYTES = 60000;
const MOST_BYTES = 1000000;
const EVERY_MS = 1000;
const CONTROLLER = 'controller';

// ui.logs: by name {name, from, to, size, text, error, requestedAt, busy}
async function read(ctx, log, from) {
  if (log.busy) return;
  log.busy = true;
  log.requestedAt = ctx.now;
  try {
    const answer = await get('api/log', {actuator: log.name, from});
    const fits = log.text !== null && answer.from === log.to;
    if (fits) {
      log.text = (log.text + answer.text).slice(-MOST_BYTES);
      log.to = answer.to;
    } else if (log.text === null || answer.from < log.from || answer.to < log.to || answer.from > log.to) {
      Object.assign(log, {from: answer.from, to: answer.to, text: answer.text});
    }
    log.size = answer.size;
    log.error = '';
  } catch (error) {
    log.error = error.message || t('no_answer');
  }
  log.busy = false;
  ctx.redraw();
}

function follow(ctx, name) {
  const logs = (ctx.ui.logs ??= new Map());
  if (!logs.has(name)) logs.set(name, {name, from: 0, to: 0, size: 0, text: null, error: '', requestedAt: 0});
  const log = logs.get(name);
  if (log.busy || ctx.now - log.requestedAt < EVERY_MS) return log;
  if (log.text === null) read(ctx, log, -PART_BYTES);
  else if (ctx.ui.follow !== false) read(ctx, log, log.to);
  return log;
}

function stayAtEnd(ctx, element) {
  const observer = new MutationObserver(() => {
    if (ctx.ui.follow !== false) element.scrollTop = element.scrollHeight;
  });
  observer.observe(element, {childList: true, characterData: true, subtree: true});
  element.scrollTop = element.scrollHeight;
}

// Those of the address; else the controller's.
export function chosenLogs(requested, names) {
  const chosen = names.filter(name => requested.split(',').includes(name));
  return chosen.length ? chosen : [CONTROLLER];
}

function chooser(names, chosen) {
  const shown = name => (name === CONTROLLER ? t('log.controller') : name);
  const toggle = name => {
    const next = names.filter(n => (n === name ? !chosen.includes(n) : chosen.includes(n)));
    location.hash = `log/${encodeURIComponent(next.join(','))}`;
  };
  return h('details', {class: 'log-chooser'},
    h('summary', null, `${t('log.of')} ${chosen.map(shown).join(', ')}`),
    h('div', {class: 'filters', role: 'group', 'aria-label': t('log.of')}, names.map(name =>
      h('button', {key: name, class: 'button small', 'aria-pressed': String(chosen.includes(name)),
        onclick: () => toggle(name)}, shown(name)))));
}

function filters(ctx) {
  return h('div', {class: 'filters'},
    h('label', {for: 'log-level'}, t('log.level')),
    h('select', {id: 'log-level', value: ctx.ui.logLevel ?? 'debug', onchange: event => {
      ctx.ui.logLevel = event.target.value;
      ctx.redraw();
    }}, LEVELS.map(level => h('option', {key: level, value: level}, t(`log.level.${level}`)))),
    h('label', {for: 'log-find'}, t('log.find')),
    h('input', {type: 'search', id: 'log-find', value: ctx.ui.find ?? '', oninput: event => {
      ctx.ui.find = event.target.value;
      ctx.redraw();
    }}),
    h('label', {class: 'check'}, h('input', {type: 'checkbox', checked: true, onchange: event => {
      ctx.ui.follow = event.target.checked;
      ctx.redraw();
    }}), t('log.follow')));
}

export function leave(ctx) {
  ctx.ui.logs = new Map();
}

export function view(ctx) {
  const names = [CONTROLLER, ...(statusOf(ctx.state)?.actuators ?? []).map(a => a.name)];
  const chosen = chosenLogs(ctx.route.rest[0] ?? '', names);
  const logs = chosen.map(name => follow(ctx, name));
  const lines = chosenLines(merged(logs.map(log => readLines(log.text ?? '', log.name))),
    {level: ctx.ui.logLevel, find: ctx.ui.find, several: logs.length > 1});
  const size = logs.reduce((sum, log) => sum + log.size, 0);
  const older = logs.filter(log => log.from > 0);
  const loading = logs.some(log => log.text === null && !log.error);
  return [h('h1', {class: 'hidden'}, t('nav.log')), card(t('nav.log'), {id: 'log-title',
    aside: h('span', {class: 'quiet small'}, t('log.matches', {count: lines.length}), ' · ', bytes(size))},
  chooser(names, chosen), filters(ctx),
  logs.filter(log => log.error).map(log => h('p', {key: log.name, class: 'quiet'},
    commands(`${log.name}: ${t('log.none', {why: log.error})}`))),
  older.length ? h('button', {class: 'button small', onclick: () => older.forEach(log =>
    read(ctx, log, Math.max(0, log.from - PART_BYTES * 4)))}, t('log.older')) : null,
  size === 0 && !loading && !logs.some(log => log.error) ? h('p', {class: 'quiet'}, t('log.empty'))
    : h('pre', {class: 'log', tabindex: '0', lang: 'en', role: 'group', 'aria-labelledby': 'log-title',
      ref: element => stayAtEnd(ctx, element)}, loading ? t('loading') : lines.join('\n')))];
}
