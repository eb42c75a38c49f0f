// The emergency stop, in every header: what the page shows may be old. One press engages it; its release
// needs a confirmation.
import {post} from './connection.js';
import {h} from './dom.js';
import {t} from './i18n.js';
import {plainText, shape} from './parts.js';
import {mayAct, mayStop, shownMachine, statusOf} from './store.js';

// The server answers after 3 s at the latest.
export const ANSWER_MS = 4500;
const OCTAGON = 'M5 0.500h6L15.500 5v6L11 15.500H5L0.500 11V5z';

// 0: done.
async function done(answer) {
  const {code, reason = ''} = await answer;
  if (code) throw new Error(reason || t('code', {code}));
  return reason;
}

async function engage(ctx) {
  ctx.ui.stopping = true;
  ctx.redraw();
  try {
    const note = await done(post('api/estop', {...shownMachine(ctx.state), reason: t('stop.reason')},
      {within_ms: ANSWER_MS}));
    if (note) ctx.alarm(t('stop.not_kept', {why: note}));
    else ctx.say(t('stop.sent'));
  } catch (error) {
    ctx.alarm(t('stop.failed', {why: error.message || t('no_answer')}));
  }
  ctx.ui.stopping = false;
  ctx.redraw();
}

async function release(ctx) {
  // A later stop is not released; without ids all would be.
  const seen = {...shownMachine(ctx.state), stop_ids: statusOf(ctx.state)?.stop_ids ?? []};
  if (!seen.stop_ids.length) return;
  const yes = await ctx.confirm({title: t('stop.confirm.title'), text: t('stop.confirm.text'),
    yes: t('stop.confirm.yes'), no: t('stop.confirm.no')});
  if (!yes) return;
  try {
    await done(post('api/release', seen));
    ctx.say(t('stop.released'));
  } catch (error) {
    ctx.alarm(t('failed', {why: error.message || t('no_answer')}));
  }
}

export function releaseButton(ctx) {
  const allowed = mayAct(ctx.state);
  return h('button', {key: 'release', class: 'button small release', disabled: !allowed,
    'aria-label': t('stop.release.label'), 'aria-describedby': allowed ? null : 'look-how',
    onclick: () => release(ctx)}, t('stop.release'));
}

// `before`: of a dialog, which blocks the rest of the page.
export function stopButton(ctx, before) {
  const may = mayStop(ctx.state);
  return h('button', {key: 'stop', class: 'stop', disabled: !may,
    'aria-describedby': may ? null : 'look-how', title: may ? null
      : plainText(t('stop.login', {how: t('look.how')})),
    'aria-label': t('stop'), onclick: () => {
      before?.();
      engage(ctx);
    }},
  shape(OCTAGON), ctx.ui.stopping ? t('stop.sending') : t('stop.short'));
}
