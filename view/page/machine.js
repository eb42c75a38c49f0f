// The first view: in what state the robot is, what is wrong, why, and what can be done.
import {h} from './dom.js';
import {duration, when} from './format.js';
import {t} from './i18n.js';
import {batteryBar, card, codeNote, commands, docsLink, facts, levelShape, quoted, stateChip, stateMeaning,
  stoppedChip} from './parts.js';
import {acknowledgement, capabilitiesOf, freshness, levelOf, problems, recentFaults, robotNow, stateSince,
  statusOf} from './store.js';
import {requestPlan, switchCard} from './switch.js';
import {eventRow} from './why.js';

// Events that come once for each actuator, and would hide the others.
const ROUTINE = new Set(['command_done', 'actuator_present', 'process_started', 'process_found']);

function stateCard(ctx, status) {
  const since = stateSince(ctx.state);
  const phase = t(`phase.${status.phase}`);
  return card(t('state'), {id: 'state-title', class: 'state-card', aside: h('span', {class: 'quiet'}, phase)},
    h('p', {class: 'big-state'}, status.emergency_stop ? stoppedChip({large: true}) : null,
      stateChip(status.state, {large: !status.emergency_stop}),
      status.target && status.target !== status.state
        ? h('span', {class: 'towards'}, '→ ', stateChip(status.target)) : null),
    h('p', {class: 'meaning'}, status.emergency_stop ? t('state.stopped') : stateMeaning(status.state),
      since ? h('span', {class: 'quiet'}, ' ', t('state.since',
        {time: duration(robotNow(ctx.state, ctx.now) - since)})) : null),
    summaryOfActuators(status));
}

function summaryOfActuators(status) {
  const states = new Map();
  for (const a of status.actuators ?? []) {
    const state = a.presence === 'present' ? a.state : a.presence;
    states.set(state, (states.get(state) ?? 0) + 1);
  }
  return h('p', {class: 'counts'}, h('span', {class: 'quiet'}, `${t('nav.actuators')}:`),
    [...states].map(([state, count]) =>
    h('a', {key: state, href: '#actuators'}, h('span', null, count), ' ', stateChip(state))));
}

// What the advice asks for, where it is a switch: its plan is shown first.
function adviceButton(ctx, problem) {
  const target = {set_again: statusOf(ctx.state).state, self_check: 'SelfCheck'}[problem.advice];
  if (!target) return null;
  return h('p', {class: 'buttons'}, h('button', {class: 'button small',
    onclick: () => requestPlan(ctx, target, '')},
  problem.advice === 'set_again' ? t('switch.again', {state: target}) : t('switch.go', {state: target})));
}

function problemItem(ctx, problem) {
  const actuator = problem.id.startsWith('actuator ');
  return h('li', {key: problem.id, class: `problem ${problem.level}`}, levelShape(problem.level),
    h('div', null,
      h('h3', null, h('span', {class: 'hidden'}, t(`level.${problem.level}`), ': '),
        t(problem.what, {name: problem.name})),
      problem.why ? h('p', {class: 'reason'}, quoted(problem.why), codeNote(problem.why, problem.code)) : null,
      h('p', {class: 'advice'}, h('b', null, t('advice')), ' ', t(`advice.${problem.advice}`)),
      adviceButton(ctx, problem),
      h('p', {class: 'links'},
        actuator ? h('a', {href: `#actuators/${encodeURIComponent(problem.name)}`}, t('wrong.see')) : null,
        actuator || problem.id === 'stop' || problem.id === 'start'
          ? h('a', {href: `#timeline/why/${actuator ? encodeURIComponent(problem.name) : ''}`,
            'aria-label': `${t('why')} ${t(problem.what, {name: problem.name})}`}, t('why'))
              : null)));
}

// What went wrong lately stays until a person has seen it, also when all is well again.
function faultList(ctx, below) {
  const faults = recentFaults(ctx.state, ctx.now, ctx.ui.acknowledged);
  if (faults.length === 0) return null;
  const seen = acknowledgement(ctx.state);
  return h('div', {class: below ? 'past below' : 'past', key: 'past'},
    h('p', {class: 'quiet'}, t('faults.past', {count: faults.length})),
    h('ol', {class: 'events'}, faults.slice(0, 5).map(entry => eventRow(entry, {time: when(entry.ms, ctx.now)}))),
    h('p', {class: 'buttons'}, h('button', {class: 'button small',
      onclick: () => ctx.acknowledge(seen)}, t('faults.acknowledge'))));
}

function attentionCard(ctx, status) {
  const list = problems(ctx.state);
  const past = faultList(ctx, list.length > 0);
  const all = status.actuators?.length ?? 0;
  if (list.length === 0) {
    const fresh = freshness(ctx.state, ctx.now) === 'live';
    const well = (status.actuators ?? []).filter(a => a.presence === 'present' && a.health === 'well').length;
    return card(t('wrong'), {id: 'wrong-title', class: 'wrong-card'},
      h('p', {class: 'all-well'}, fresh ? levelShape('ok') : null,
        h('b', null, t(fresh ? 'wrong.none' : 'wrong.stale')),
        fresh ? [' ', h('span', {class: 'quiet'}, t('wrong.none.detail', {well, all}))] : null), past);
  }
  return card(t('wrong'), {id: 'wrong-title', class: 'wrong-card',
    aside: h('span', {class: `count ${list[0].level}`}, list.length)},
  h('ul', {class: 'problems'}, list.map(problem => problemItem(ctx, problem))), past);
}

function powerCard(status) {
  const policy = status.policy ?? {};
  if (!policy.active) return card(t('power'), {id: 'power-title'}, h('p', {class: 'quiet'}, t('power.none')));
  return card(t('power'), {id: 'power-title'}, facts([
    [t('power.battery'), policy.battery >= 0 ? batteryBar(policy) : t('power.unknown')],
    [t('power.ceiling'), policy.ceiling ? [stateChip(policy.ceiling), ' ', quoted(policy.ceiling_reason)]
      : t('power.any')],
    policy.kept ? [t('power.kept'), t('power.kept.for',
      {state: policy.kept, time: duration(policy.keep_s * 1000)})] : null,
    [t('power.still'), t(policy.low_power_switch ? 'on' : 'off')],
  ]));
}

function capabilityItem(capability) {
  const reason = capability.reason
    || t('can.needs', {actuators: (capability.actuators ?? []).join(', ')});
  return h('li', {key: capability.name, class: capability.allowed ? 'can' : 'cannot'},
    levelShape(capability.allowed ? (capability.reason ? 'warn' : 'ok') : 'info'),
    h('div', null, h('b', null, capability.name), ' ',
      h('span', {class: `pill ${capability.allowed ? 'tone-ok' : 'tone-off'}`},
        t(capability.allowed ? 'can.yes' : 'can.no')),
      capability.description ? h('p', null, quoted(capability.description)) : null,
      h('p', {class: 'quiet'}, capability.reason ? quoted(reason) : reason,
        capability.states?.length ? ` · ${t('can.states', {states: capability.states.join(', ')})}` : '')));
}

function capabilitiesCard(ctx) {
  const list = capabilitiesOf(ctx.state);
  return card(t('can'), {id: 'can-title'}, list.length === 0
    ? h('p', {class: 'quiet'}, commands(t('can.none')))
    : h('ul', {class: 'capabilities'}, list.map(capabilityItem)));
}

function recentCard(ctx) {
  const last = ctx.state.history.slice(-300).filter(e => levelOf(e)
    || !ROUTINE.has(e.event)).slice(-6).reverse();
  return card(t('recent'), {id: 'recent-title', aside: h('a', {href: '#timeline'}, t('recent.all'))},
    last.length === 0 ? h('p', {class: 'quiet'}, t('recent.none'))
      : h('ol', {class: 'events'}, last.map(entry => eventRow(entry, {time: when(entry.ms, ctx.now)}))));
}

function aboutCard(ctx, status) {
  return card(t('about'), {id: 'about-title'}, facts([
    [t('about.controller'), t('about.controller.value', {pid: status.pid, host: status.host})],
    [t('about.config'), h('code', null, status.config_file)],
    [t('about.namespace'), status.name_space || '/'],
    [t('about.starts'), String(status.epoch)],
    [t('about.version'), ctx.state.hello?.version ?? ''],
  ]), h('p', {class: 'links'}, docsLink()));
}

export function view(ctx) {
  const status = statusOf(ctx.state);
  if (!status) return [h('h1', {class: 'hidden'}, t('nav.robot')),
    freshness(ctx.state, ctx.now) === 'waiting' ? null : h('p', {class: 'loading'}, t('loading'))];
  return [h('h1', {class: 'hidden'}, t('nav.robot')), h('div', {class: 'board'},
    h('div', {class: 'column', key: 'main'}, stateCard(ctx, status), attentionCard(ctx, status),
      switchCard(ctx, status)),
    h('div', {class: 'column', key: 'side'}, capabilitiesCard(ctx), powerCard(status), recentCard(ctx),
      aboutCard(ctx, status)))];
}
