// The login: by the PIN that `musher view` prints, in a dialog; and its end.
import {ApiError, post} from './connection.js';
import {draw, h} from './dom.js';
import {stopButton} from './estop.js';
import {t} from './i18n.js';
import {commands} from './parts.js';

const DIGITS = 6;

// Reloads the page, which then knows who acts.
export function loginDialog(ctx, parent) {
  const ui = {error: '', busy: false};
  let dialog = null;
  let input = null;
  const redraw = () => draw(parent, [dialogOf()]);
  async function send(event) {
    event.preventDefault();
    const pin = input.value.replace(/\D/g, '');
    Object.assign(ui, {busy: pin.length === DIGITS, error: pin.length === DIGITS ? '' : t('login.digits')});
    redraw();
    if (!ui.busy) return;
    try {
      await post('api/login', {pin});
      location.reload();
    } catch (error) {
      Object.assign(ui, {busy: false, error: (error instanceof ApiError && error.message) || t('no_answer')});
      redraw();
      input.select();
    }
  }
  const dialogOf = () => h('dialog', {'aria-labelledby': 'login-title', onclose: () => draw(parent, []),
    ref: element => (dialog = element)},
  h('h2', {id: 'login-title'}, t('login')),
  h('form', {method: 'dialog', onsubmit: send},
    h('p', {id: 'login-how'}, commands(t('login.how'))),
    h('p', null, h('label', {for: 'pin'}, t('login.pin')), ' ',
      h('input', {id: 'pin', type: 'text', inputmode: 'numeric', autocomplete: 'one-time-code', maxlength: 9,
        size: 9, 'aria-describedby': 'login-how login-error', ref: element => (input = element)})),
    h('p', {id: 'login-error', class: 'tone-bad', role: 'alert'}, commands(ui.error)),
    h('p', {class: 'buttons'},
      h('button', {class: 'button', onclick: () => dialog.close()}, t('cancel')),
      h('button', {type: 'submit', class: 'button primary', disabled: ui.busy}, t('login')),
      stopButton(ctx, () => dialog.close()))));
  redraw();
  dialog.showModal();
  input.focus();
}

export async function logout(ctx, all) {
  if (all) {
    const yes = await ctx.confirm({title: t('logout.all'), text: t('logout.all.text'), yes: t('logout.all'),
      no: t('cancel')});
    if (!yes) return;
  }
  try {
    await post('api/logout', {all});
    location.reload();
  } catch (error) {
    ctx.alarm(t('failed', {why: error.message || t('no_answer')}));
  }
}
