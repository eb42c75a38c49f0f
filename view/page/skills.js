// The skills of an actuator: what each one does, its run, and a run, its pause or its cancellation by a person who
// may act. ui.skill is null or {key, error, busy}: the skill whose parameters are being typed.
import {post} from './connection.js';
import {h} from './dom.js';
import {t} from './i18n.js';
import {actButton, card, commands, quoted} from './parts.js';
import {shownMachine, statusOf} from './store.js';

// "altitude_m: number, default 1, 0.2 to 10" -> {name, hint, required}
export function readParameter(text) {
  const [name, ...rest] = text.split(':');
  const hint = rest.join(':').trim();
  return {name: name.trim(), hint, required: !/\bdefault\b/.test(hint)};
}

async function request(ctx, path, body, said) {
  try {
    await post(path, {...shownMachine(ctx.state), ...body});
    ctx.say(said);
    return '';
  } catch (error) {
    return error.message || t('no_answer');
  }
}

async function run(ctx, offers, offer, form) {
  const parameters = {};
  for (const {name} of (offer.parameters ?? []).map(readParameter)) {
    const value = form.elements.namedItem(name)?.value.trim();
    if (value) parameters[name] = value;
  }
  const chosen = ctx.ui.skill;
  Object.assign(chosen, {busy: true, error: ''});
  ctx.redraw();
  chosen.error = await request(ctx, 'api/skill', {action: offers.action, actuator: offers.actuator,
    skill: offer.skill, parameters}, t('skill.begun', {name: offer.skill}));
  chosen.busy = false;
  if (!chosen.error && ctx.ui.skill === chosen) ctx.ui.skill = null;
  ctx.redraw();
}

async function cancel(ctx, offers, offer, feedback) {
  // A run that goes on after a restart has no goal.
  const run = feedback.goal_id ? {action: offers.action, goal_id: feedback.goal_id}
    : {actuator: offers.actuator, skill: offer.skill};
  const why = await request(ctx, 'api/cancel_skill', run, t('skill.cancelling', {name: offer.skill}));
  if (why) ctx.alarm(t('failed', {why}));
}

// A run that is paused by a request says so in a detail.
function isPaused(feedback) {
  return feedback?.status === 0 && (feedback.details ?? []).some(({key}) => key === 'paused');
}

async function pause(ctx, offers, offer, stop) {
  const why = await request(ctx, 'api/pause_skill', {actuator: offers.actuator, skill: offer.skill, pause: stop},
    t(stop ? 'skill.pausing' : 'skill.resuming', {name: offer.skill}));
  if (why) ctx.alarm(t('failed', {why}));
}

function pauseButton(ctx, offers, offer, paused) {
  return actButton(ctx, t(paused ? 'skill.resume' : 'skill.pause'), () => pause(ctx, offers, offer, !paused),
    {label: t(paused ? 'skill.resume.of' : 'skill.pause.of', {name: offer.skill})});
}

function parametersForm(ctx, offers, offer, key) {
  const {busy, error} = ctx.ui.skill;
  const close = () => {
    ctx.ui.skill = null;
    ctx.redraw();
  };
  return h('form', {class: 'skill-form', key: `form ${key}`, onsubmit: event => {
    event.preventDefault();
    run(ctx, offers, offer, event.target);
  }},
  (offer.parameters ?? []).map(readParameter).map(({name, hint, required}, i) => h('p', {key: name},
    h('label', {for: `parameter-${i}`}, name),
    h('input', {id: `parameter-${i}`, name, type: 'text', required, autocomplete: 'off',
      'aria-describedby': `hint-${i}`}),
    h('span', {id: `hint-${i}`, class: 'quiet small', lang: 'en'}, hint))),
  error ? h('p', {class: 'tone-bad', role: 'alert'}, commands(t('skill.refused', {why: error}))) : null,
  h('p', {class: 'buttons'},
    h('button', {type: 'submit', class: 'button primary', disabled: busy}, t('skill.run.now', {name: offer.skill})),
    h('button', {class: 'button', onclick: close}, t('cancel'))));
}

function buttons(ctx, offers, offer, feedback, key) {
  const runs = feedback?.status === 0 && feedback.state !== 'IDLE';
  return h('p', {class: 'buttons'},
    runs ? pauseButton(ctx, offers, offer, isPaused(feedback)) : null,
    runs ? actButton(ctx, t('cancel'), () => cancel(ctx, offers, offer, feedback),
      {label: t('skill.cancel.of', {name: offer.skill})}) : null,
    runs ? null : actButton(ctx, t('skill.run'), () => {
      ctx.ui.skill = {key, error: '', busy: false};
      ctx.redraw();
      if (offer.parameters?.length) ctx.focus('parameter-0');
    }, {label: t('skill.run.of', {name: offer.skill})}));
}

function skillItem(ctx, offers, offer) {
  const key = `${offers.actuator} ${offer.skill}`;
  const feedback = ctx.state.feedback[key];
  return h('li', {key: offer.skill, class: 'skill'},
    h('p', null, h('b', null, offer.skill), ' ', quoted(offer.summary)),
    feedback ? [h('p', null, h('span', {class: `pill tone-${['busy', 'ok', 'bad', 'off'][feedback.status]}`},
      isPaused(feedback) ? t('app.paused') : t(`skill.${feedback.status}`)),
      ` ${feedback.state} `, quoted(feedback.message)),
    h('progress', {max: 100, value: feedback.progress, 'aria-label': `${offer.skill}: ${t('app.progress')}`}),
    h('p', {class: 'quiet small', lang: 'en'},
      (feedback.details ?? []).map(d => `${d.key} ${d.value}`).join(' · '))]
      : h('p', {class: 'quiet small'}, t('app.skill.none')),
    ctx.ui.skill?.key === key ? parametersForm(ctx, offers, offer, key)
      : buttons(ctx, offers, offer, feedback, key));
}

export function skillsCard(ctx, name) {
  const offers = ctx.state.offers[name];
  const actuator = statusOf(ctx.state)?.actuators?.find(a => a.name === name);
  const off = actuator && actuator.state !== 'Active' && actuator.presence === 'present';
  return card(t('app.skills'), {id: `skills-${name}`},
    off ? h('p', {class: 'quiet'}, t('off.in', {state: actuator.state})) : null,
    h('ul', {class: 'skills'}, (offers?.skills ?? []).map(offer => skillItem(ctx, offers, offer))));
}
