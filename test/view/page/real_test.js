// The page as the real server sends it, in a browser: the embedded files with their headers, the WebSocket and
// its subprotocol, a request that acts. The robot behind it is scripted.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {once} from 'node:events';
import path from 'node:path';
import {createInterface} from 'node:readline';
import {after, before, test} from 'node:test';
import {open, startBrowser, until} from './browser.js';
import {MockRobot} from './mock_robot.js';
import {PAGE} from './mock_server.js';

const program = path.join(process.env.MUSHER_BIN ?? path.resolve(PAGE, '../../build/dev/bin'),
  'view_page_server');
const posts = [];
let server = null;
let url = '';
let browser = null;

before(async () => {
  server = spawn(program, {stdio: ['pipe', 'pipe', 'inherit']});
  const lines = createInterface({input: server.stdout});
  const [port] = await once(lines, 'line');
  lines.on('line', line => posts.push(line));
  url = `http://127.0.0.1:${port}/`;
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  server?.stdin.end();
  if (server?.exitCode === null) await once(server, 'exit');
});

test('the embedded page shows a robot, and its emergency stop reaches the server', async () => {
  const send = message => server.stdin.write(`${JSON.stringify(message)}\n`);
  send({op: 'hello', version: '0.1.0', namespace: '', may_act: true, who: 'alice', time_ms: Date.now()});
  const robot = new MockRobot(send);
  robot.greeting().forEach(send);
  const {page, close} = await open(browser, {url});
  assert.match(await page.textContent('.state-card'), /Active/);
  robot.fault('audio');
  await page.waitForSelector('.problem >> text=audio has crashed');
  await page.click('.stop');
  await until('the stop is received', () => posts.length > 0);
  assert.equal(posts[0], '/api/estop {"reason":"button of the page"}');
  const icon = await page.evaluate(async () => (await fetch('icon.svg')).headers.get('content-type'));
  assert.equal(icon, 'image/svg+xml');
  await page.reload();
  await page.waitForSelector('.problem >> text=audio has crashed');
  await close();
});
