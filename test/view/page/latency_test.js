// How soon the page shows something useful, and how soon a message is on the screen. The times are printed;
// the limits are wide, for slow computers.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {open, startBrowser} from './browser.js';

const MESSAGES = 100;
let browser = null;
before(async () => (browser = await startBrowser()));
after(() => browser?.close());

const wallNow = () => performance.timeOrigin + performance.now();

test('the first useful paint and the latency of updates', async () => {
  const opened = await open(browser);
  const {page, robot} = opened;
  await page.reload();
  const first = await page.evaluate(() => new Promise(done => {
    const look = () => (document.querySelector('.big-state') ? done(performance.now())
      : requestAnimationFrame(look));
    look();
  }));
  await page.evaluate(() => {
    globalThis.shown = new Map();
    new MutationObserver(() => {
      const text = document.querySelector('.battery b')?.textContent;
      if (text === undefined || globalThis.shown.has(text)) return;
      globalThis.shown.set(text, 0);
      requestAnimationFrame(() => setTimeout(() => globalThis.shown.set(text,
        performance.timeOrigin + performance.now())));
    }).observe(document.getElementById('main'), {subtree: true, characterData: true, childList: true});
  });
  const times = [];
  for (let i = 0; i < MESSAGES; ++i) {
    robot.policy.battery = 200 + i;
    const sent = wallNow();
    robot.publish();
    const key = `${200 + i} %`;
    const shown = await page.waitForFunction(k => globalThis.shown.get(k) || null, key,
      {polling: 'raf'}).then(handle => handle.jsonValue());
    times.push(shown - sent);
  }
  times.sort((a, b) => a - b);
  const at = share => times[Math.min(times.length - 1, Math.floor(times.length * share))];
  console.log(`first useful paint ${first.toFixed(0)} ms; message to pixel p50 ${at(0.5).toFixed(1)} ms, p99 ${at(0.99).toFixed(1)} ms`);
  await opened.close();
  assert.ok(first < 10000);
  assert.ok(at(0.5) < 1000);
});
