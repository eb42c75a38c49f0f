// musher-view beside a robot of real processes, in a real browser: what a person sees and does.
import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {once} from 'node:events';
import {readFile} from 'node:fs/promises';
import net from 'node:net';
import path from 'node:path';
import {after, before, test} from 'node:test';
import WebSocket from 'ws';
import {open, startBrowser, until} from '../page/browser.js';
import {startRobot} from '../robot.js';

let robot = null;
let view = null;
let browser = null;
before(async () => {
  robot = await startRobot();
  view = await robot.view('--name', 'anna');
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  await robot?.close();
});

const api = (path, options) => fetch(new URL(path, view.url), options);
const post = (path, body, headers = {}) => api(path, {method: 'POST', body: JSON.stringify(body), headers});

async function session() {
  const {path} = await (await post('api/link', {token: view.token, name: 'anna'})).json();
  const answer = await api(path, {redirect: 'manual'});
  assert.equal(answer.status, 303);
  return answer.headers.get('set-cookie').split(';')[0];
}

// {page, close} of a page whose person may act.
async function openActing() {
  const {path} = await (await post('api/link', {token: view.token, name: 'anna'})).json();
  return open(browser, {url: new URL(path, view.url).href});
}

test('a person without a login sees the robot, and cannot act', async () => {
  const {page, close} = await open(browser, {url: view.url});
  await page.waitForSelector('.big-state >> text=Active');
  await page.waitForSelector('text=walk about');
  await page.waitForSelector('text=Looking only');
  await close();
  const answer = await post('api/set', {target: 'DeActive'});
  assert.equal(answer.status, 403);
  assert.match((await answer.json()).error.message, /acting needs a login/);
  assert.equal((await post('api/release', {})).status, 403);
});

test('a person without a login can stop the robot, and not release it', async () => {
  const {page, close} = await open(browser, {url: view.url});
  await page.waitForSelector('.big-state >> text=Active');
  await page.click('.stop');
  await page.waitForSelector('.banner.bad >> text=Emergency stop is engaged');
  assert.ok(await page.isDisabled('.release'));
  await close();
  const {emergency_stop: stop} = await robot.status();
  assert.equal(stop.engaged, true);
  assert.match(stop.by, /^a person without a login \(127\.0\.0\.1\)/);
  await robot.musher('estop', '--release');
  await robot.musher('set', 'Active');
});

test('a switch shows its plan first, then its outcome', async () => {
  const {page, close} = await openActing();
  await page.click('.choice:has-text("DeActive")');
  await page.waitForSelector('#plan >> text=Wave 2');
  assert.equal((await robot.status()).state, 'Active');
  await page.click('#plan .primary');
  await page.waitForSelector('.outcome >> text=Done: the robot is in DeActive');
  await page.waitForSelector('.big-state >> text=DeActive');
  await close();
  assert.match(await robot.musher('history'), /switch to DeActive requested by anna \(127\.0\.0\.1\) on the page/);
  assert.equal((await robot.status()).state, 'DeActive');
  await robot.musher('set', 'Active');
});

test('an emergency stop reaches the robot with the name of the person, and is released', async () => {
  const {page, close} = await openActing();
  await page.click('.stop');
  await page.waitForSelector('.banner.bad >> text=Emergency stop is engaged');
  const {emergency_stop: stop} = await robot.status();
  assert.equal(stop.engaged, true);
  assert.match(stop.by, /^anna \(/);
  await page.click('.choice:has-text("Active") >> nth=0');
  await page.waitForSelector('#plan >> text=emergency stop');
  await page.click('.release');
  await page.click('dialog .danger');
  await page.waitForSelector('.release', {state: 'detached'});
  await close();
  assert.equal((await robot.status()).emergency_stop.engaged, false);
  await robot.musher('set', 'Active');
});

test('a controller that dies is reported, and its successor takes over on the page', async () => {
  const {page, close} = await open(browser, {url: view.url});
  await page.waitForSelector('.big-state >> text=Active');
  process.kill((await robot.status()).pid, 'SIGKILL');
  await page.waitForSelector('.banner.bad >> text=The controller has ended');
  await robot.up();
  await page.waitForSelector('.banner.bad', {state: 'detached'});
  await page.waitForSelector('.big-state >> text=Active');
  await close();
});

async function audioIsBack(before) {
  const {audio} = (await robot.status()).actuators;
  return audio.pid !== before && audio.state === 'Active';
}

test('an actuator that crashes, its history and its log are on the page', async () => {
  const {page, close} = await open(browser, {url: view.url});
  const {pid} = (await robot.status()).actuators.audio;
  process.kill(pid, 'SIGKILL');
  await page.waitForSelector('text=audio: restarting');
  await page.click('nav >> text=Log');
  await page.waitForSelector('pre.log >> text=audio is degraded: crashed');
  await close();
  const {entries} = await (await api('api/history?limit=50')).json();
  const crash = entries.find(entry => entry.event === 'actuator_crashed' || /audio is degraded: crashed/.test(entry.message));
  assert.ok(BigInt(crash.wall_ns) > 10n ** 18n);
  await until('audio is back', () => audioIsBack(pid));
});

test('a crash is seen on a phone: what crashed and why, also once it is over', async () => {
  const {page, close} = await open(browser, {url: view.url, width: 390, height: 844});
  await page.waitForSelector('.events .event');
  if (await page.locator('#top .faults').count() > 0) await page.click('button:has-text("Acknowledge")');
  await page.waitForSelector('#top .faults', {state: 'detached'});
  const {pid} = (await robot.status()).actuators.audio;
  process.kill(pid, 'SIGKILL');
  await page.waitForSelector('#top .faults');
  await until('audio is back', () => audioIsBack(pid));
  await page.waitForSelector('.past .event.bad >> text=audio is degraded: crashed');
  const [width, inner] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(width <= inner, `${width} px in ${inner}`);
  await page.evaluate(() => scrollTo(0, 0));  // where a click has scrolled to a button
  for (const seen of ['.big-state', '#top .faults', '.stop']) {
    const {y, height} = await page.locator(seen).boundingBox();
    assert.ok(y >= 0 && y + height <= 844, `${seen} needs no scrolling`);
  }
  await page.click('button:has-text("Acknowledge")');
  await page.waitForSelector('#top .faults', {state: 'detached'});
  await close();
});

test('a page that reads nothing gets the present when it reads again, and costs no memory', async () => {
  const resident = async () => Number(/VmRSS:\s+(\d+)/.exec(
    await readFile(`/proc/${view.child.pid}/status`, 'utf8'))[1]);
  const socket = new WebSocket(`${view.url.replace('http', 'ws')}live`, 'musher.view.v1');
  await once(socket, 'open');
  socket.pause();
  const before = await resident();
  for (let i = 0; i < 20; ++i) await robot.musher('set', i % 2 ? 'Active' : 'DeActive');
  assert.ok(await resident() - before < 20000, 'kB');
  const last = new Promise(done => socket.on('message', text => {
    const message = JSON.parse(text);
    if (message.topic?.endsWith('machine_status') && message.message?.switch_number >= 20 &&
      message.message.state === 'Active') done();
  }));
  socket.resume();
  await last;
  socket.close();
});

test('a link opens one session, a wrong token none, and a foreign page none at all', async () => {
  const {path} = await (await post('api/link', {token: view.token, name: 'anna'})).json();
  assert.equal((await api(path, {redirect: 'manual'})).status, 303);
  assert.equal((await api(path, {redirect: 'manual'})).status, 403);
  assert.equal((await post('api/link', {token: '0'.repeat(32)})).status, 403);
  const cookie = await session();
  assert.equal((await post('api/plan', {target: 'Active'}, {cookie})).status, 200);
  assert.equal((await post('api/release', {}, {cookie, origin: 'http://evil.example'})).status, 403);
});

test('a login ends, with the connections that it has opened', async () => {
  const cookie = await session();
  const socket = new WebSocket(`${view.url.replace('http', 'ws')}live`, 'musher.view.v1', {headers: {cookie}});
  await once(socket, 'open');
  const closed = once(socket, 'close');
  const answer = await post('api/logout', {}, {cookie});
  assert.equal(answer.status, 200);
  assert.match(answer.headers.get('set-cookie'), /Max-Age=0/);
  assert.equal((await closed)[0], 1000);
  assert.equal((await post('api/release', {}, {cookie})).status, 403);
});

test('a person ends the login on the page, and looks on', async () => {
  const {page, close} = await openActing();
  await page.click('text=End the login');
  await page.waitForSelector('text=Looking only');
  await close();
});

test('a login by a PIN outlives a restart of the server, and ends by a command', async () => {
  const free = net.createServer().listen(0, '127.0.0.1');
  await once(free, 'listening');
  const port = String(free.address().port);
  free.close();
  await once(free, 'close');
  const first = await robot.view('--port', port);
  const to = (path, body, cookie) => fetch(new URL(path, first.url),
    {method: 'POST', body: JSON.stringify(body), headers: cookie ? {cookie} : {}});
  const wrong = first.pin === '000000' ? '000001' : '000000';
  assert.equal((await to('api/login', {pin: wrong})).status, 403);
  const answer = await to('api/login', {pin: first.pin});
  assert.equal(answer.status, 200);
  const cookie = answer.headers.get('set-cookie').split(';')[0];
  const mayAct = async () => {
    await until('it follows the machine', async () => (await to('api/plan', {target: 'Active'})).status === 200);
    const {status} = await to('api/restart', {actuator: 'none'}, cookie);
    assert.ok(status === 404 || status === 403, `${status}`);
    return status === 404;
  };
  assert.ok(await mayAct());
  first.child.kill('SIGKILL');
  await once(first.child, 'exit');
  await robot.view('--port', port);
  assert.ok(await mayAct(), 'the session is that of before');
  execFileSync(`${process.env.MUSHER_BIN}/musher-view`, ['--port', port, '--logout'], {env: robot.env});
  assert.ok(!await mayAct());
});

test('bad requests are refused with a sentence', async () => {
  const cookie = await session();
  for (const [path, body, status] of [['api/set', [], 400], ['api/plan', 7, 400], ['api/nothing', {}, 404],
    ['api/restart', {actuator: '../x'}, 404], ['api/restart', {}, 404],
    ['api/set', {target: 'DeActive', actuator: 5}, 400], ['api/set', {target: 'DeActive', actautor: 'audio'}, 400],
    ['api/release', {stop_ids: '12'}, 400]]) {
    const answer = await post(path, body, {cookie});
    assert.equal(answer.status, status, path);
    assert.ok((await answer.json()).error.message.length > 10);
  }
  for (const [path, status] of [['api/log?actuator=../../etc/passwd', 404], ['api/behavior?name=motion', 404],
    ['camera?topic=/none', 404], ['nothing', 404], ['api/log?actuator=audio&from=99999999999', 200],
    ['api/history?limit=-1', 200], ['api/history?limit=x', 200]]) {
    assert.equal((await api(path)).status, status, path);
  }
  const deep = `{"parameters":{"x":${'['.repeat(500000)}${']'.repeat(500000)}}}`;
  assert.equal((await api('api/skill', {method: 'POST', body: deep, headers: {cookie}})).status, 400);
  const {outcome, reason} = await (await post('api/set', {target: 'Nowhere'}, {cookie})).json();
  assert.equal(outcome, 'refused');
  assert.match(reason, /unknown state 'Nowhere'/);
});

test('a request for another machine than the one that is followed does nothing', async () => {
  const cookie = await session();
  const {machine, machine_id} = await robot.status();
  const other = {machine: 'cat', machine_id: '00000000-0000-0000-0000-000000000000'};
  for (const [path, body] of [['api/set', {target: 'DeActive'}], ['api/release', {}],
    ['api/restart', {actuator: 'audio'}]]) {
    const answer = await post(path, {...body, ...other}, {cookie});
    assert.equal(answer.status, 409, path);
    assert.match((await answer.json()).error.message, /the page shows cat \(id 00000000\), but dog .*Nothing was done/);
  }
  assert.equal((await robot.status()).state, 'Active');
  const set = await post('api/set', {target: 'Active', machine, machine_id}, {cookie});
  assert.equal((await set.json()).outcome, 'done');
});

test('what may move the robot is refused where the request is held up on its way; what stops it is not', async () => {
  const cookie = await session();
  const socket = new WebSocket(`${view.url.replace('http', 'ws')}live`, 'musher.view.v1');
  const [hello] = await once(socket, 'message');
  socket.close();
  const seen_uptime_ms = JSON.parse(hello).uptime_ms - 31000;
  const late = (path, body) => post(path, {...body, seen_uptime_ms}, {cookie});
  assert.equal((await (await late('api/set', {target: 'DeActive'})).json()).outcome, 'done');
  for (const [path, body] of [['api/set', {target: 'Active'}], ['api/set', {target: 'Active', actuator: 'audio'}],
    ['api/release', {}], ['api/restart', {actuator: 'audio'}], ['api/skill', {actuator: 'audio'}],
    ['api/pause_skill', {actuator: 'audio', skill: 'goto', pause: false}]]) {
    const answer = await late(path, body);
    assert.equal(answer.status, 409, path);
    assert.match((await answer.json()).error.message, /is late: what its page shows is 3\d s old. Nothing was done/);
  }
  assert.equal((await post('api/set', {target: 'Active', seen_uptime_ms: '1'}, {cookie})).status, 400);
  assert.equal((await robot.status()).state, 'DeActive');
  assert.equal((await late('api/estop', {reason: 'late'})).status, 200);
  assert.equal((await robot.status()).emergency_stop.engaged, true);
  await robot.musher('estop', '--release');
  await robot.musher('set', 'Active');
});

test('a machine is named by the environment, and by the beginning of its id', async () => {
  const {machine_id} = await robot.status();
  const follows = async word => {
    robot.env.MUSHER_MACHINE = word;
    const {url} = await robot.view();
    delete robot.env.MUSHER_MACHINE;
    return async () => (await fetch(new URL('api/plan', url),
      {method: 'POST', body: JSON.stringify({target: 'Active'})})).status === 200;
  };
  const none = await follows('cat');
  await until('it follows the machine', await follows(machine_id.slice(0, 8)));
  assert.equal(await none(), false);
});

test('a page that sends something else than what it watches is closed', async () => {
  for (const text of ['{', '[]', '{"op":"set"}', '{"op":"watch"}', '{"op":"watch","topics":7}']) {
    const socket = new WebSocket(`${view.url.replace('http', 'ws')}live`, 'musher.view.v1');
    await once(socket, 'open');
    socket.send(text);
    const [code] = await once(socket, 'close');
    assert.equal(code, 1008, text);
  }
});

test('with [view] in the config the page is served, served again after a crash, and ends with the robot', async () => {
  const free = net.createServer().listen(0, '127.0.0.1');
  await once(free, 'listening');
  const {port} = free.address();
  free.close();
  await once(free, 'close');
  const url = `http://127.0.0.1:${port}/`;
  const up = async () => (await fetch(`${url}metrics`).catch(() => null))?.ok;
  const pids = () => execFileSync('pgrep', ['-f', `musher-view --port ${port}`]).toString().trim().split('\n');
  const own = await startRobot(`\n[view]\nport = ${port}\n`);
  try {
    await until('the page', up);
    for (const pid of pids()) process.kill(Number(pid), 'SIGKILL');
    await until('the page after a crash', up);
    const log = await readFile(path.join(own.stateFolder, 'controller.log'), 'utf8');
    assert.match(log, /musher-view ended: killed by SIGKILL; the page is served again in 1 s/);
  } finally {
    await own.close();
  }
  assert.equal(await up(), undefined);
});

test('a second musher-view on the port prints a link of the first', async () => {
  const port = new URL(view.url).port;
  const second = spawn(`${process.env.MUSHER_BIN}/musher-view`, ['--port', port], {env: robot.env});
  let said = '';
  second.stdout.on('data', text => (said += text));
  const [code] = await once(second, 'exit');
  assert.equal(code, 0);
  assert.match(said, /is at http:\S+ already\.\nTo act, open http/);
});

test('a port of another program is in use, and the reason is printed', async () => {
  const other = net.createServer().listen(0, '127.0.0.1');
  await once(other, 'listening');
  other.on('connection', socket => socket.end('SSH-2.0-none\r\n'));
  const child = spawn(`${process.env.MUSHER_BIN}/musher-view`, ['--port', String(other.address().port)],
    {env: robot.env});
  let said = '';
  child.stderr.on('data', text => (said += text));
  const [code] = await once(child, 'exit');
  other.close();
  assert.equal(code, 1);
  assert.match(said, /in use.*--port takes another one/);
});
