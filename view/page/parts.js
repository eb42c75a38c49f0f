// Small parts that several views draw: a state with its shape, a card, a button that needs the login.
import {h} from './dom.js';
import {has, language, t} from './i18n.js';
import {mayAct} from './store.js';

// Every state has a shape and a tone, so that it is known without colours too.
const SHAPES = {
  Active: ['ok', 'M8 1a7 7 0 1 0 0 14a7 7 0 0 0 0-14z'],
  Protected: ['warn', 'M8 1l6 2v5c0 4-3 6-6 7c-3-1-6-3-6-7V3z'],
  DeActive: ['calm', 'M2 2h12v12H2z'],
  LowPower: ['calm', 'M10.5 1.2a7 7 0 1 0 4.3 9.3a6 6 0 0 1-4.3-9.3z'],
  OTA: ['busy', 'M8 1l6 7h-4v7H6V8H2z'],
  SetUp: ['busy', 'M2 2h12v3H2zM2 6.5h8v3H2zM2 11h5v3H2z'],
  SelfCheck: ['busy', 'M6.3 13.6L1 8.3l2-2 3.300 3.300L13 2.900l2 2z'],
  Error: ['bad', 'M8 0.500L15.500 15H0.500z'],
  lost: ['bad', 'M3 1L8 6l5-5 2 2-5 5 5 5-2 2-5-5-5 5-2-2 5-5-5-5z'],
  crashed: ['bad', 'M3 1L8 6l5-5 2 2-5 5 5 5-2 2-5-5-5 5-2-2 5-5-5-5z'],
  TearDown: ['off', 'M7 1h2v7H7zM4.500 3.200l1 1.700a5 5 0 1 0 5 0l1-1.700a7 7 0 1 1-7 0z'],
  absent: ['off', 'M2 7h12v2H2z'],
  starting: ['busy', 'M2 2h12v3H2zM2 6.500h8v3H2zM2 11h5v3H2z'],
  Uninitialized: ['off', 'M2 7h12v2H2z'],
};
const STOP = 'M5 0.5h6L15.500 5v6L11 15.500H5L0.500 11V5z';
const OTHER = ['own', 'M8 0.500L15.500 8L8 15.500L0.500 8z'];

export const toneOf = state => (SHAPES[state] ?? OTHER)[0];

export function shape(path, kind = '') {
  return h('svg', {class: `shape ${kind}`, viewBox: '0 0 16 16', 'aria-hidden': 'true', focusable: 'false'},
    h('path', {d: path}));
}

const LEVELS = {
  bad: 'M8 0.500L15.500 15H0.500zM7 5v5h2V5zM7 11.500v2h2v-2z',
  warn: 'M8 1L15 8L8 15L1 8zM7 4.500v4.500h2V4.500zM7 10v1.700h2V10z',
  info: 'M8 1a7 7 0 1 0 0 14a7 7 0 0 0 0-14zM7 4v2h2V4zM7 7v5h2V7z',
  ok: 'M6.300 13.600L1 8.300l2-2 3.300 3.300L13 2.900l2 2z',
};
export const levelShape = level => shape(LEVELS[level], `tone-${level === 'info' ? 'busy' : level}`);

// A state as its shape and its name; `pale` where it only accompanies something.
export function stateChip(state, {large = false} = {}) {
  if (!state) return h('span', {class: 'chip tone-off'}, '–');
  const [tone, path] = SHAPES[state] ?? OTHER;
  const known = {absent: 'health.absent', lost: 'health.lost', starting: 'health.starting'}[state];
  return h('span', {class: `chip tone-${tone}${large ? ' large' : ''}`}, shape(path),
    known ? t(known) : state);
}

export function batteryBar(policy) {
  const level = policy.battery;
  const tone = policy.charging ? 'ok' : level <= 10 ? 'bad' : level <= 25 ? 'warn' : 'ok';
  return h('span', {class: 'battery'},
    h('span', {class: 'battery-case', 'aria-hidden': 'true'},
      h('span', {class: `battery-level fill-${tone}`, style: {width: `${Math.max(3, level)}%`}})),
    h('b', null, `${level} %`), policy.charging ? h('span', {class: 'quiet'}, ` ${t('power.charging')}`)
      : null);
}

// Instead of the state while an emergency stop is engaged.
export const stoppedChip = ({large = false} = {}) =>
  h('span', {class: `chip stopped${large ? ' large' : ''}`}, shape(STOP), t('stopped.big'));

export function stateMeaning(state) {
  return has(`state.${state}`) ? t(`state.${state}`) : t('state.other');
}

// What the robot itself wrote, in its own language.
export const quoted = text => h('span', {lang: 'en'}, commands(text ?? ''));

// The code beside a sentence that does not have it yet.
export const codeNote = (text, code) => (code && !(text ?? '').includes(String(code))
  ? h('span', {class: 'quiet'}, ` (${t('code', {code})})`) : null);

export function card(title, props, ...children) {
  const id = props.id ?? `card-${title}`.replace(/\W+/g, '-');
  return h('section', {class: `card ${props.class ?? ''}`, 'aria-labelledby': id, key: props.key ?? id},
    h('div', {class: 'card-head'}, h('h2', {id}, title), props.aside ?? null), children);
}

export function facts(rows) {
  return h('dl', {class: 'facts'}, rows.filter(Boolean).map(([name, ...value]) =>
    h('div', {key: name}, h('dt', null, name), h('dd', null, value))));
}

// A button for what changes the robot. Without the login it is disabled, and describes how to get it.
export function actButton(ctx, text, onclick, {kind = '', disabled = false, label} = {}) {
  const allowed = mayAct(ctx.state);
  return h('button', {class: `button ${kind}`, onclick: allowed && !disabled ? onclick : null,
    disabled: !allowed || disabled, 'aria-label': label, 'aria-describedby': allowed ? null : 'look-how',
    title: allowed ? null : plainText(t('look.how'))}, text);
}

// How to get the login, beside disabled controls. `id` is once on a page: in the banner.
export function lookHint(ctx) {
  if (mayAct(ctx.state)) return null;
  return h('p', {class: 'hint'}, commands(t('look.how')));
}

// `text` in backquotes becomes <code>.
export function commands(text) {
  return text.split('`').map((part, i) => (i % 2 === 1 ? h('code', null, part) : part));
}

// In the header where it has room, else below the last card.
export const docsLink = () => h('a', {key: 'docs', class: 'docs', target: '_blank', rel: 'noopener',
  href: language() === 'en' ? 'docs/' : 'docs/README.zh.html'}, t('nav.docs'));

export const plainText = text => text.replaceAll('`', '');
