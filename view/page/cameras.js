// The pictures of the robot's cameras. The next one is fetched when the last one is shown, so a slow link
// gets fewer pictures, never older ones.
import {h} from './dom.js';
import {duration} from './format.js';
import {t} from './i18n.js';
import {card, commands} from './parts.js';
import {robotNow, statusOf} from './store.js';

const TYPES = new Set(['sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage']);
const RETRY_MS = 1000;

// The front cameras first, pictures in colour before others; depths and the back last.
const rank = name => 4 * /rear|back|depth/.test(name) + 2 * !/front/.test(name) + !/rgb|colou?r/.test(name);
export const camerasOf = topics => topics.filter(topic => TYPES.has(topic.type) && topic.publishers > 0)
  .map(topic => topic.name).sort((a, b) => rank(a) - rank(b) || (a < b ? -1 : 1));

// Fetches and draws until `camera.canvas` is taken away.
async function run(ctx, topic, camera, canvas) {
  let after = 0;
  while (camera.canvas === canvas && canvas.isConnected) {
    const width = Math.min(1280,
      Math.max(160, Math.round(canvas.clientWidth * (globalThis.devicePixelRatio || 1))));
    try {
      const query = new URLSearchParams({topic, after_ms: String(after), width: String(width)});
      const response = await fetch(`camera?${query}`, {cache: 'no-store', signal: camera.abort.signal});
      if (response.status === 204) {
        camera.waiting = true;
      } else if (!response.ok) {
        throw new Error((await response.json().catch(() => null))?.error?.message ?? `HTTP ${response.status}`);
      } else {
        after = Number(response.headers.get('X-Stamp-Ms')) || after;
        const picture = await createImageBitmap(await response.blob());
        if (canvas.width !== picture.width || canvas.height !== picture.height) {
          canvas.width = picture.width;
          canvas.height = picture.height;
        }
        canvas.getContext('2d').drawImage(picture, 0, 0);
        picture.close();
        camera.times = [...camera.times.slice(-9), performance.now()];
        Object.assign(camera, {stamp: after, waiting: false, error: ''});
      }
    } catch (error) {
      if (camera.abort.signal.aborted) return;
      camera.error = error.message;
      await new Promise(done => setTimeout(done, RETRY_MS));
    }
    await new Promise(requestAnimationFrame);  // none in a hidden tab, so nothing is fetched there
    ctx.redraw();
  }
}

function textOf(ctx, camera) {
  if (camera.error) return commands(t('failed', {why: camera.error}));
  if (camera.waiting) {
    const state = statusOf(ctx.state)?.state;
    return state && state !== 'Active' ? t('off.in', {state}) : t('cameras.wait');
  }
  if (camera.times.length === 0) return t('loading');
  const span = camera.times.at(-1) - camera.times[0];
  const rate = span > 0 ? (((camera.times.length - 1) * 1000) / span).toFixed(span > 5000 ? 1 : 0) : '–';
  return t('cameras.age', {rate, age: duration(robotNow(ctx.state, ctx.now) - camera.stamp)});
}

function cameraCard(ctx, topic, hidden) {
  const cameras = (ctx.ui.cameras ??= new Map());
  const toggle = () => {
    if (hidden.has(topic)) hidden.delete(topic);
    else hidden.add(topic);
    stop(ctx, topic);
    ctx.redraw();
  };
  const button = h('button', {class: 'button small', onclick: toggle,
    'aria-label': `${t(hidden.has(topic) ? 'cameras.show' : 'cameras.hide')} ${topic}`},
    t(hidden.has(topic) ? 'cameras.show' : 'cameras.hide'));
  if (hidden.has(topic)) return card(topic, {key: topic, aside: button});
  const start = canvas => {
    const camera = {canvas, abort: new AbortController(), times: [], stamp: 0, waiting: false, error: ''};
    cameras.set(topic, camera);
    requestAnimationFrame(() => run(ctx, topic, camera, canvas));
  };
  const camera = cameras.get(topic);
  return card(topic, {key: topic, aside: button},
    h('canvas', {class: 'picture', width: 640, height: 480, role: 'img',
      'aria-label': t('cameras.picture', {topic}), ref: start}),
    h('p', {class: 'quiet small'}, camera ? textOf(ctx, camera) : t('loading')));
}

function stop(ctx, topic) {
  const camera = ctx.ui.cameras?.get(topic);
  if (!camera) return;
  camera.canvas = null;
  camera.abort.abort();
  ctx.ui.cameras.delete(topic);
}

export function leave(ctx) {
  for (const topic of [...(ctx.ui.cameras?.keys() ?? [])]) stop(ctx, topic);
}

export function view(ctx) {
  const topics = camerasOf(ctx.state.topics);
  const hidden = (ctx.ui.hiddenCameras ??= new Set(topics.slice(2)));
  return [h('h1', {class: 'hidden'}, t('nav.cameras')), topics.length === 0
    ? card(t('nav.cameras'), {}, h('p', {class: 'quiet'}, t('cameras.none')))
    : [h('p', {class: 'quiet intro'}, t('cameras.intro')),
      h('div', {class: 'pictures'}, topics.map(topic => cameraCard(ctx, topic, hidden)))]];
}
