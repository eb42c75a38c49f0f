// Events, and the chain of causes of one.
import {h} from './dom.js';
import {clockFine, day, duration} from './format.js';
import {t} from './i18n.js';
import {commands, levelShape, quoted, shape} from './parts.js';
import {levelOf} from './store.js';

const DOT = 'M8 5a3 3 0 1 0 0 6a3 3 0 0 0 0-6z';
const keyOf = entry => `${entry.epoch}/${entry.id}/${entry.ms}/${entry.message}`;

export function eventRow(entry, {time, open = false} = {}) {
  const level = levelOf(entry);
  return h('li', {key: keyOf(entry), class: `event ${level}${open ? ' chosen' : ''}`},
    h('time', {datetime: new Date(entry.ms).toISOString()}, time),
    level ? levelShape(level) : shape(DOT, 'tone-off'),
    h('a', {class: 'event-text', lang: 'en', href: `#timeline/${entry.epoch}/${entry.id}`}, commands(entry.message)));
}

// The entry and its causes, as far as they are known: {chain, complete}.
export function chainOf(history, entry) {
  const byId = new Map(history.filter(e => e.id !== 0).map(e => [`${e.epoch}/${e.id}`, e]));
  const chain = [entry];
  const seen = new Set([entry]);
  for (let at = entry; at.cause !== 0;) {
    const next = byId.get(`${at.epoch}/${at.cause}`);
    if (!next || seen.has(next)) return {chain, complete: false};
    chain.push(next);
    seen.add(next);
    at = next;
  }
  return {chain, complete: true};
}

// The last event that says why an actuator, or ("") the machine, is as it is.
export function eventToExplain(history, actuator) {
  for (let i = history.length - 1; i >= 0; --i) {
    const entry = history[i];
    if (actuator ? entry.actuator === actuator && entry.code !== 0 : entry.state !== ''
      || entry.event === 'emergency_stop_engaged') return entry;
  }
  if (!actuator) return null;
  return history.findLast(entry => entry.actuator === actuator) ?? null;
}

function dataPart(entry) {
  // JSON is for programs: the sentence has the same values.
  if (!entry.data || entry.data.startsWith('{')) return null;
  return h('details', null, h('summary', null, t('why.data')),
    h('pre', {lang: 'en', tabindex: '0'}, entry.data));
}

export function whyPanel(history, entry, close) {
  const {chain, complete} = chainOf(history, entry);
  return h('section', {class: 'card why', id: 'why', tabindex: '-1', 'aria-labelledby': 'why-title',
    key: 'why'},
    h('div', {class: 'card-head'}, h('h2', {id: 'why-title'}, t('why')),
      h('button', {class: 'button small', onclick: close}, t('close'))),
    h('p', {class: 'quiet'}, t('why.chain')),
    h('ol', {class: 'chain'}, chain.map((link, i) => h('li', {key: keyOf(link), class: levelOf(link)},
      i > 0 ? h('span', {class: 'because'}, i === chain.length - 1 && complete ? t('why.first')
        : t('why.because'),
        chain[i - 1].ms - link.ms >= 1
          ? ` · ${t('why.earlier', {time: duration(chain[i - 1].ms - link.ms)})}` : '') : null,
      h('p', {class: 'chain-text'}, levelOf(link) ? levelShape(levelOf(link)) : shape(DOT, 'tone-off'), ' ',
        quoted(link.message)),
      h('p', {class: 'quiet small'}, `${day(link.ms)} ${clockFine(link.ms)}`,
        link.actuator ? ` · ${link.actuator}` : '',
        link.event ? ` · ${link.event}` : '', link.code ? ` · ${t('code', {code: link.code})}` : ''),
      dataPart(link)))),
    complete ? null : h('p', {class: 'quiet'}, t('why.incomplete')));
}
