// A modal dialog that confirms what cannot be taken back.
import {draw, h} from './dom.js';
import {stopButton} from './estop.js';

// True for yes; Escape, STOP and the other button say no.
export function confirmDialog(ctx, parent, {title, text, yes, no}) {
  return new Promise(resolve => {
    let answer = false;
    let dialog = null;
    const end = value => {
      answer = value;
      dialog.close();
    };
    const onclose = () => {
      draw(parent, []);
      resolve(answer);
    };
    draw(parent, [h('dialog', {class: 'confirm', 'aria-labelledby': 'confirm-title',
      'aria-describedby': 'confirm-text', onclose,
      ref: element => (dialog = element)},
    h('h2', {id: 'confirm-title'}, title), h('p', {id: 'confirm-text'}, text),
    h('p', {class: 'buttons'},
      h('button', {class: 'button', onclick: () => end(false)}, no),
      h('button', {class: 'button danger', onclick: () => end(true)}, yes),
      stopButton(ctx, () => end(false))))]);
    dialog.showModal();
  });
}
