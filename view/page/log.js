// The log of an actuator or of the controller: its end is followed, earlier parts are read on request.
import {get} from './connection.js';
import {h} from './dom.js';
import {bytes} from './format.js';
import {t} from './i18n.js';
import {card} from './parts.js';
import {statusOf} from './store.js';

const PART_BYTES = 60000;
const MOST_BYTES = 1000000;
const EVERY_MS = 1000;
const CONTROLLER = 'controller';

// ui.log: {name, from, to, size, text, error, requestedAt, busy}
async function read(ctx, from) {
  const log = ctx.ui.log;
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
  if (ctx.ui.log?.name !== name) ctx.ui.log = {name, from: 0, to: 0, size: 0, text: null, error: '',
    requestedAt: 0};
  const log = ctx.ui.log;
  if (log.busy || ctx.now - log.requestedAt < EVERY_MS) return log;
  if (log.text === null) read(ctx, -PART_BYTES);
  else if (ctx.ui.follow !== false) read(ctx, log.to);
  return log;
}

function stayAtEnd(ctx, element) {
  const observer = new MutationObserver(() => {
    if (ctx.ui.follow !== false) element.scrollTop = element.scrollHeight;
  });
  observer.observe(element, {childList: true, characterData: true, subtree: true});
  element.scrollTop = element.scrollHeight;
}

function lineParts(text, find) {
  const lines = text.trimEnd().split('\n');
  if (find === '') return {text: lines.join('\n'), count: lines.length};
  const low = find.toLowerCase();
  const found = lines.filter(line => line.toLowerCase().includes(low));
  return {text: found.join('\n'), count: found.length};
}

export function view(ctx) {
  const names = [CONTROLLER, ...(statusOf(ctx.state)?.actuators ?? []).map(a => a.name)];
  const requested = ctx.route.rest[0] ?? '';
  const name = names.includes(requested) ? requested : CONTROLLER;
  const log = follow(ctx, name);
  const find = ctx.ui.find ?? '';
  const shown = lineParts(log.text ?? '', find);
  return [h('h1', {class: 'hidden'}, t('nav.log')), card(t('nav.log'), {id: 'log-title',
    aside: h('span', {class: 'quiet small'}, t('log.matches', {count: shown.count}), ' · ', bytes(log.size))},
  h('div', {class: 'filters'},
    h('label', {for: 'log-of'}, t('log.of')),
    h('select', {id: 'log-of', value: name,
      onchange: event => (location.hash = `log/${encodeURIComponent(event.target.value)}`)},
      names.map(n => h('option', {value: n, key: n}, n === CONTROLLER ? t('log.controller') : n))),
    h('label', {for: 'log-find'}, t('log.find')),
    h('input', {type: 'search', id: 'log-find', value: find, oninput: event => {
      ctx.ui.find = event.target.value;
      ctx.redraw();
    }}),
    h('label', {class: 'check'}, h('input', {type: 'checkbox', checked: true, onchange: event => {
      ctx.ui.follow = event.target.checked;
      ctx.redraw();
    }}), t('log.follow'))),
  log.error ? h('p', {class: 'quiet'}, t('log.none', {why: log.error})) : null,
  log.from > 0 ? h('button', {type: 'button', class: 'button small',
    onclick: () => read(ctx, Math.max(0, log.from - PART_BYTES * 4))}, t('log.older')) : null,
  log.text === '' ? h('p', {class: 'quiet'}, t('log.empty'))
    : h('pre', {class: 'log', tabindex: '0', lang: 'en', role: 'group', 'aria-labelledby': 'log-title',
      ref: element => stayAtEnd(ctx, element)},
      log.text === null && !log.error ? t('loading') : shown.text))];
}
