// A browser for the tests of the page: one for all tests of a file, a new context for each page. Errors of a
// page, and violations of its content security policy, fail the test that closes it.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {chromium} from 'playwright-core';
import {MockServer, PAGE} from './mock_server.js';

const BROWSERS = [process.env.CHROMIUM, '/usr/bin/chromium'].filter(Boolean);
const DEADLINE_MS = 180000;
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const IMAGES = path.resolve(PAGE, '../../docs/images');

export function startBrowser() {
  const root = process.getuid?.() === 0;
  return chromium.launch({executablePath: BROWSERS[0], args: root ? ['--no-sandbox'] : []});
}

// A server with a robot, and a page that shows it. `close` ends both.
export async function open(browser, {hash = 'robot', mayAct = true, mayStop = true, denied = false,
  width = 1280, height = 900, dark = false, locale = 'en', url} = {}) {
  const server = url ? null : await new MockServer({mayAct, mayStop, denied}).listen();
  const context = await browser.newContext({viewport: {width, height}, colorScheme: dark ? 'dark' : 'light',
    locale, reducedMotion: 'reduce',
    hasTouch: width < 600});
  const page = await context.newPage();
  page.setDefaultTimeout(DEADLINE_MS);
  const errors = [];
  page.on('pageerror', error => errors.push(error.message));
  page.on('console', message => {
    if (/Content.Security.Policy|Uncaught/.test(message.text())) errors.push(message.text());
  });
  await page.goto(`${url ?? server.url}#${hash}`);
  await page.waitForSelector(denied ? '.banner' : '.card');
  return {server, robot: server?.robot, page, errors, context,
    async close() {
      await context.close();
      await server?.close();
      assert.deepEqual(errors, []);
    }};
}

export async function axeViolations(page) {
  await page.evaluate(axe);
  const result = await page.evaluate(() => globalThis.axe.run(document, {resultTypes: ['violations'],
    runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']}));
  return result.violations.map(v => `${v.id}: ${v.help}: ${v.nodes.map(n => `${n.target} ${n.any[0]?.message ?? ''}`).slice(0, 4).join(' | ')}`);
}

// What the page has said of its connection, which takes longer on a busy computer.
const CONNECTION = /^(live|old|waiting|no controller|Connecting to the robot …|实时|已过时|等待中|无控制器|正在连接机器人…)$/;

// The words on the page, one text a line, without what differs from run to run: numbers, times, its connection.
async function wordsOf(page) {
  const text = await page.evaluate(() => [document.body.innerText,
    ...[...document.querySelectorAll('svg text')].map(node => node.textContent)].join('\n'));
  return text.replace(/\d+/g, '0').split('\n').map(line => line.trim())
    .filter(line => line && !/^[0:. ]+$/.test(line) && !CONNECTION.test(line)).join('\n') + '\n';
}

// A picture of docs/images. MUSHER_SCREENSHOTS=1 makes it; in the night it must show the present page: its words
// are those of pictures/NAME.txt, which are written with it.
export async function screenshot(page, name, options = {}) {
  const words = path.join(IMAGES, `../../test/view/page/pictures/${name}.txt`);
  if (process.env.MUSHER_SCREENSHOTS) {
    await page.screenshot({path: path.join(IMAGES, `view_${name}.png`), ...options});
    writeFileSync(words, await wordsOf(page));
  } else if (process.env.MUSHER_NIGHTLY === '1') {
    assert.equal(await wordsOf(page), readFileSync(words, 'utf8'),
      `docs/images/view_${name}.png shows an older page; MUSHER_SCREENSHOTS=1 node --test page_test.js makes it again`);
  }
}

// Waits until `read` returns something true; fails with `what` at the deadline.
export async function until(what, read) {
  const end = Date.now() + DEADLINE_MS;
  for (;;) {
    const value = await read();
    if (value) return value;
    assert.ok(Date.now() < end, `not within ${DEADLINE_MS} ms: ${what}`);
    await new Promise(done => setTimeout(done, 20));
  }
}

// A gate that a test opens: `wait` of the robot's switch waits for it.
export function gate() {
  let release = null;
  const opened = new Promise(done => (release = done));
  return {opened, release};
}
