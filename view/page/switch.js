// A change of the state: choose it, see the plan, confirm, watch its legs, see the outcome. ui.switch is
// null, or {target, actuator, shown, step: "requesting"|"plan"|"going"|"ended", plan, answer, error}.
import {post} from './connection.js';
import {h} from './dom.js';
import {duration} from './format.js';
import {t} from './i18n.js';
import {actButton, card, codeNote, commands, levelShape, lookHint, quoted, stateChip} from './parts.js';
import {legState, mayAct, offeredStates, shownMachine} from './store.js';

export async function requestPlan(ctx, target, actuator) {
  const change = {target, actuator, step: 'requesting', shown: shownMachine(ctx.state)};
  ctx.ui.switch = change;
  ctx.redraw();
  try {
    change.plan = await post('api/plan', {target, actuator});
  } catch (error) {
    change.error = error.message || t('no_answer');
  }
  change.step = 'plan';
  ctx.redraw();
  if (ctx.ui.switch === change) ctx.focus('plan');
}

async function go(ctx) {
  const change = ctx.ui.switch;
  change.step = 'going';
  ctx.redraw();
  ctx.focus('plan');
  try {
    change.answer = await post('api/set', {...change.shown, target: change.target, actuator: change.actuator});
  } catch (error) {
    if (error.status === 0) change.answer = {outcome: 'lost', reason: error.message, actuators: []};
    else change.error = error.message;
  }
  change.step = 'ended';
  const state = change.answer?.state;
  ctx.say(change.error ? t('failed', {why: change.error}) : t(`outcome.${change.answer.outcome}`, {state}));
  ctx.redraw();
}

function end(ctx) {
  ctx.ui.switch = null;
  ctx.redraw();
  ctx.focus('switch-title');
}

function chooser(ctx, status) {
  const actuator = ctx.ui.switchOf ?? '';
  const present = actuator ? status.actuators.find(a => a.name === actuator)?.state : status.state;
  return [
    h('p', {class: 'quiet'}, t('switch.choose')),
    h('p', {class: 'switch-of'}, h('label', {for: 'switch-of'}, t('switch.of')), ' ',
      h('select', {id: 'switch-of', value: actuator, onchange: event => {
        ctx.ui.switchOf = event.target.value;
        ctx.redraw();
      }}, h('option', {value: '', key: ''}, t('switch.machine')),
      status.actuators.map(a => h('option', {value: a.name, key: a.name}, a.name)))),
    h('div', {class: 'choices', role: 'group', 'aria-labelledby': 'switch-title'},
      offeredStates(ctx.state).map(name => h('button', {key: name, class: 'choice',
        onclick: () => requestPlan(ctx, name, actuator)}, stateChip(name),
      name === present ? h('span', {class: 'here'}, t('switch.present')) : null))),
  ];
}

function waves(plan) {
  const groups = new Map();
  for (const step of plan.steps ?? []) groups.set(step.wave, [...(groups.get(step.wave) ?? []), step]);
  return [...groups].sort(([a], [b]) => (a || 1e9) - (b || 1e9));
}

const LEG_TONES = {done: 'ok', running: 'busy', waiting: 'off', trouble: 'bad', refused: 'bad', failed: 'bad',
  overdue: 'bad', lost: 'bad', undone: 'warn', skipped: 'off', unsupported: 'off'};

function legLabel(step, change, status) {
  if (change.step === 'plan') return step.wave > 0 ? h('span', {class: 'quiet'},
    t('switch.within', {time: duration(step.deadline_ms)})) : null;
  const outcome = change.answer?.actuators?.find(a => a.name === step.name);
  if (outcome) {
    return h('span', {class: `pill tone-${LEG_TONES[outcome.outcome] ?? 'off'}`},
      t(`leg.outcome.${outcome.outcome}`),
      outcome.duration_ms > 0 ? ` · ${duration(outcome.duration_ms)}` : '');
  }
  if (step.wave === 0 || change.step === 'ended') return null;
  const leg = legState(status.actuators.find(a => a.name === step.name), step.to);
  return h('span', {class: `pill tone-${LEG_TONES[leg]}`}, t(`leg.${leg}`));
}

function stepRow(step, change, status) {
  const outcome = change.answer?.actuators?.find(a => a.name === step.name);
  return h('li', {key: step.name, class: 'leg'},
    h('b', null, step.name),
    h('span', {class: 'leg-way'}, step.wave > 0
      ? [stateChip(step.from), ' → ', stateChip(step.to)] : stateChip(step.from)),
    legLabel(step, change, status),
    step.note ? h('p', {class: 'reason'}, quoted(step.note)) : null,
    outcome?.message ? h('p', {class: 'reason'}, quoted(outcome.message)) : null);
}

function planList(change, status) {
  const groups = waves(change.plan);
  const last = groups.filter(([wave]) => wave > 0).length;
  return h('ol', {class: 'waves'}, groups.map(([wave, steps]) => h('li', {key: wave, class: 'wave'},
    h('h4', null, wave > 0 ? t('switch.wave', {wave}) : t('switch.wave.none'),
      wave > 0 && wave < last ? h('span', {class: 'quiet'}, ` – ${t('switch.wave.text')}`) : null),
    h('ul', null, steps.map(step => stepRow(step, change, status))))));
}

function outcomePart(change) {
  const answer = change.answer;
  const good = answer.outcome === 'done';
  const level = good ? 'ok' : answer.outcome === 'done-degraded' || answer.outcome === 'superseded' ? 'warn'
    : 'bad';
  return h('div', {class: `outcome ${level}`}, levelShape(level), h('div', null,
    h('b', null, t(`outcome.${answer.outcome}`, {state: answer.state ?? ''})),
    answer.reason ? h('p', {class: 'reason'}, quoted(answer.reason), codeNote(answer.reason, answer.code)) : null));
}

function planButtons(ctx, change) {
  const refused = change.plan && !change.plan.allowed;
  if (change.step === 'going') return h('p', {class: 'busy'}, t('switch.going', {state: change.target}));
  if (change.step === 'ended') {
    return h('p', {class: 'buttons'}, h('button', {class: 'button', onclick: () => end(ctx)},
      t('switch.new')));
  }
  return [h('p', {class: 'buttons'},
    change.error || refused ? null : actButton(ctx, t('switch.go', {state: change.target}), () => go(ctx),
      {kind: change.target === 'TearDown' ? 'danger' : 'primary'}),
    h('button', {class: 'button', onclick: () => end(ctx)},
      t(change.error || refused ? 'switch.new' : 'cancel'))),
  change.error || refused || mayAct(ctx.state) ? null : lookHint(ctx)];
}

function planPart(ctx, status) {
  const change = ctx.ui.switch;
  if (change.step === 'requesting') return h('p', {class: 'quiet'}, t('switch.requesting'));
  const plan = change.plan;
  const refused = plan && !plan.allowed;
  const open = plan?.allowed && change.step === 'plan';
  return h('div', {class: 'plan', key: 'plan', id: 'plan', tabindex: '-1', role: 'group',
    'aria-labelledby': 'plan-title'},
    h('h3', {id: 'plan-title'}, change.actuator ? `${change.actuator}: ` : '',
      t('switch.plan', {from: plan?.state ?? status.state, to: change.target})),
    change.error ? h('p', {class: 'outcome bad'}, levelShape('bad'),
      h('span', null, commands(t('failed', {why: change.error})))) : null,
    refused ? h('div', {class: 'outcome bad'}, levelShape('bad'),
      h('div', null, h('b', null, t('switch.refused.plan')),
      h('p', {class: 'reason'}, quoted(plan.reason), codeNote(plan.reason, plan.code)))) : null,
    open ? h('p', {class: 'quiet'}, t(`switch.${plan.direction}`)) : null,
    open && change.target === 'TearDown'
      ? h('p', {class: 'outcome warn'}, levelShape('warn'), h('span', null, commands(t('switch.off')))) : null,
    change.answer ? outcomePart(change) : null,
    plan && plan.steps?.length ? planList(change, status) : null,
    planButtons(ctx, change));
}

export function switchCard(ctx, status) {
  return card(t('switch'), {id: 'switch-title', class: 'switch-card'},
    ctx.ui.switch ? planPart(ctx, status) : chooser(ctx, status));
}
