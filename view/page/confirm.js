// A question in the way of the page, for what cannot be taken back.
import {draw, h} from './dom.js';

// True when the person says yes; Escape and the other button say no.
export function confirmDialog(parent, {title, text, yes, no}) {
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
    draw(parent, [h('dialog', {class: 'ask', 'aria-labelledby': 'ask-title', 'aria-describedby': 'ask-text',
      onclose,
      ref: element => (dialog = element)},
    h('h2', {id: 'ask-title'}, title), h('p', {id: 'ask-text'}, text),
    h('p', {class: 'buttons'},
      h('button', {type: 'button', class: 'button', onclick: () => end(false)}, no),
      h('button', {type: 'button', class: 'button danger', onclick: () => end(true)}, yes)))]);
    dialog.showModal();
  });
}
