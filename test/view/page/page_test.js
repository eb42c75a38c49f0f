// The page in a browser, with a scripted robot behind it.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {axeViolations, gate, open, screenshot, startBrowser, until} from './browser.js';
import {PHONE, looksAt, stops} from './phone.js';

let browser = null;
before(async () => (browser = await startBrowser()));
after(() => browser?.close());

// What a request that acts says of the machine on the page.
const MACHINE = {machine: 'robot', machine_id: '5982c7ee-4c0e-4a5f-9d58-2f1f2f2a7b11'};
const VIEWS = ['robot', 'actuators', 'timeline', 'application/wedding', 'application/gardener',
  'application/skills', 'cameras', 'log'];

async function inPage(options, run) {
  const opened = await open(browser, options);
  try {
    await run(opened.page, opened);
  } finally {
    await opened.close();
  }
}

test('the first view shows the state, what is wrong and why, and what the robot can do',
  () => inPage({}, async (page, {robot}) => {
  assert.match(await page.textContent('.state-card'), /Active.*The robot works, and may move/s);
  assert.match(await page.textContent('.wrong-card'), /Nothing is wrong/);
  // A browser that is short of CPU time says for a moment that its data is old.
  await until('live', async () => /robot.*Active.*live/s.test(await page.textContent('#top')));
  robot.fault('audio');
  await page.waitForSelector('.problem >> text=audio has crashed');
  const problem = await page.textContent('.problem');
  assert.match(problem, /ended by SIGSEGV/);
  assert.match(problem, /What to do: See its log for the cause, then restart it/);
  await page.waitForSelector('.cannot >> text=audio is degraded');
  await screenshot(page, 'robot');
  assert.match(await page.title(), /^\(\d\) robot: Active/);
}));

test('the first view on a phone shows the state, what is wrong and why, the battery and STOP without scrolling',
  () => inPage({mayAct: false, ...PHONE}, async (page, {robot, server}) => {
  robot.fault('audio');
  await page.waitForSelector('.problem');
  await looksAt(page, {why: 'ended by SIGSEGV', battery: true});
  await stops(page);
  assert.deepEqual(server.requests.map(request => request.path), ['/api/estop']);
}));

test('a switch shows its plan first, then its legs, then its outcome',
  () => inPage({}, async (page, {server}) => {
  const first = gate();
  const rest = gate();
  server.waitLeg = wave => (wave === 1 ? first.opened : rest.opened);
  await page.click('.choice:has-text("LowPower")');
  await page.waitForSelector('#plan >> text=Wave 3');
  assert.deepEqual(server.requests, []);
  assert.match(await page.textContent('#plan'), /becomes less active/);
  await page.click('#plan .primary');
  await page.waitForSelector('.leg:has-text("world") >> text=running');
  await page.waitForSelector('.towards >> text=LowPower');
  first.release();
  await page.waitForSelector('.leg:has-text("world") >> text=done');
  await page.waitForSelector('.leg:has-text("camera") >> text=running');
  rest.release();
  await page.waitForSelector('.outcome >> text=Done: the robot is in LowPower');
  // The answer and the status come over two connections.
  await page.waitForSelector('.big-state >> text=LowPower');
  assert.deepEqual(server.requests, [{path: '/api/set', body: {...MACHINE, target: 'LowPower', actuator: ''}}]);
}));

test('a switch that is refused shows why and cannot be confirmed', () => inPage({}, async (page, {robot}) => {
  robot.state = 'Error';
  robot.publish();
  await page.waitForSelector('.big-state >> text=Error');
  await page.click('.choice:has-text("Active") >> nth=0');
  await page.waitForSelector('#plan >> text=from Error the machine goes to SelfCheck first');
  assert.equal(await page.locator('#plan .primary').count(), 0);
}));

test('a switch that is refused after its plan was shown reports the reason',
  () => inPage({}, async (page, {robot}) => {
  await page.click('.choice:has-text("Protected")');
  await page.waitForSelector('#plan .primary');
  robot.set = async ({target}) => ({outcome: 'refused', target, code: 111,
    reason: 'another switch is under way', state: 'Active', actuators: []});
  await page.click('#plan .primary');
  await page.waitForSelector('.outcome.bad >> text=another switch is under way');
}));

test('one press engages the emergency stop; its release needs a confirmation',
  () => inPage({}, async (page, {server, robot}) => {
  await page.click('.stop');
  await page.waitForSelector('.banner.bad >> text=Emergency stop is engaged');
  assert.equal(robot.stop.by, 'alice at 127.0.0.1');
  await page.waitForSelector('text=Stopped by an emergency stop');
  assert.match(await page.textContent('.big-state'), /^STOPPED.*Active/s);
  assert.match(await page.textContent('#top .now'), /^STOPPED/);
  for (const chip of ['.big-state .stopped', '#top .stopped']) {
    const [red, green, blue] = (await page.evaluate(at => getComputedStyle(document.querySelector(at)).backgroundColor,
      chip)).match(/\d+/g).map(Number);
    assert.ok(red > 150 && green < 60 && blue < 60, `${chip}: ${[red, green, blue]}`);
  }
  await page.click('.choice:has-text("Active") >> nth=0');
  await page.click('.release');
  await page.waitForSelector('dialog >> text=Make sure that its cause is removed');
  await page.keyboard.press('Escape');
  await page.waitForSelector('dialog', {state: 'detached'});
  assert.notEqual(robot.stop, null);
  await page.click('.release');
  await page.click('dialog .danger');
  await page.waitForSelector('.release', {state: 'detached'});
  assert.equal(robot.stop, null);
  assert.deepEqual(server.requests.map(r => [r.path, r.body]),
    [['/api/estop', {...MACHINE, reason: 'button of the page'}], ['/api/release', {...MACHINE, stop_ids: ['00000000000000a1']}]]);
}));

test('the stop can be pressed on a page that shows an old stop, and is not its release',
  () => inPage({}, async (page, {server, robot}) => {
  robot.engage('bob', 'a person is near');
  await page.waitForSelector('.release');
  robot.controllerEnds();
  await page.waitForSelector('.banner.bad >> text=The controller has ended');
  await page.click('.stop');
  await page.waitForSelector('.stop >> text=STOP');
  assert.deepEqual(server.requests.map(r => r.path), ['/api/estop']);
}));

test('a release names the stops that the person has seen',
  () => inPage({}, async (page, {server, robot}) => {
  robot.engage('bob', 'a person is near');
  await page.click('.release');
  await page.waitForSelector('dialog >> text=Make sure that its cause is removed');
  robot.engage('carol', 'a child');
  await page.waitForSelector('.banner.bad >> text=2 stops are engaged');
  await page.click('dialog .danger');
  await page.waitForFunction(() => document.querySelector('dialog') === null);
  assert.deepEqual(server.requests.map(r => r.body.stop_ids), [['00000000000000a1']]);
}));

test('the emergency stop can be pressed from each dialog, which blocks the rest of the page',
  () => inPage({hash: 'actuators'}, async (page, {server, robot}) => {
  await page.click('#actuator-camera');
  await page.click('.details button:has-text("Restart")');
  await page.click('dialog .stop');
  await page.waitForSelector('.release');
  assert.equal(await page.locator('dialog').count(), 0);
  await page.click('.release');
  await page.click('dialog .stop');
  await until('a second stop', async () => robot.stopIds.length === 2);
  assert.deepEqual(server.requests.map(r => r.path), ['/api/estop', '/api/estop']);
}));

// A browser has six connections: the stop waited unsent for one of them, and its time was over.
test('the emergency stop is sent while six requests get no answer',
  () => inPage({hash: 'actuators'}, async (page, {server}) => {
  server.delay = path => path === '/api/restart' ? new Promise(() => {}) : Promise.resolve();
  for (const name of ['world', 'motion_manager', 'audio', 'device_manager', 'sensor_manager', 'camera']) {
    await page.click(`#actuator-${name}`);
    await page.click('.details button:has-text("Restart")');
    await page.click('dialog .danger');
  }
  await page.click('.stop');
  await page.waitForSelector('.release');
  assert.deepEqual(server.requests.map(r => r.path), ['/api/estop']);
}));

test('the emergency stop can be pressed from the login',
  () => inPage({mayAct: false}, async (page, {server}) => {
  await page.click('.banner >> text=Log in');
  await page.click('dialog .stop');
  await page.waitForSelector('.banner.bad >> text=Emergency stop is engaged');
  assert.deepEqual(server.requests.map(r => r.path), ['/api/estop']);
}));

// Two robots of one image have one name, and the server is started again between the plan and the press.
test('what a person confirms is for the machine for which it was shown',
  () => inPage({}, async (page, {server, robot}) => {
  await page.click('.choice:has-text("LowPower")');
  await page.waitForSelector('#plan .primary');
  robot.machineId = 'd0900000-0000-4000-8000-000000000002';
  robot.publish();
  await page.click('#plan .primary');
  await page.waitForSelector('.outcome');
  assert.deepEqual(server.requests.map(r => r.body.machine_id), [MACHINE.machine_id]);
}));

test('an emergency stop that cannot be sent says so, loudly', () => inPage({}, async (page, {server}) => {
  server.act = async (name, body, json) => json({error: {code: 1, message: 'the session has ended'}}, 403);
  await page.click('.stop');
  await page.waitForSelector('[role=alert] >> text=NOT confirmed: the session has ended');
}));

test('an emergency stop that is not confirmed, and one that is not released, say so with the reason',
  () => inPage({}, async (page, {server, robot}) => {
  server.act = async (name, body, json) => json({code: 1, reason: 'not stopped: legs'});
  await page.click('.stop');
  await page.waitForSelector('[role=alert] >> text=NOT confirmed: not stopped: legs');
  robot.engage('bob', 'a person is near');
  await page.waitForSelector('.release');
  server.act = async (name, body, json) => json({code: 107, reason: 'legs has not confirmed the release'});
  await page.click('.release');
  await page.click('dialog .danger');
  await page.waitForSelector('[role=alert] >> text=That did not work: legs has not confirmed the release');
  assert.ok(!(await page.textContent('#said')).includes('was released'));
}));

test('an emergency stop without an answer is reported, and can be pressed again',
  () => inPage({}, async (page, {server, robot}) => {
  const never = gate();
  server.delay = () => never.opened;
  await page.click('.stop');
  await page.waitForSelector('.stop >> text=Stopping');
  await page.waitForSelector('[role=alert] >> text=NOT confirmed: no answer');
  server.delay = async () => {};
  await page.click('.stop');
  await page.waitForSelector('.release');
  assert.notEqual(robot.stop, null);
  never.release();
}));

test('without the login every acting control is disabled and says how to get it',
  () => inPage({mayAct: false}, async page => {
  assert.match(await page.textContent('#look-how'), /musher view --link/);
  assert.ok(await page.isEnabled('.stop'), 'a person who sees a robot do harm has no time to log in');
  await page.click('.choice:has-text("LowPower")');
  await page.waitForSelector('#plan >> text=Wave 1');
  assert.ok(await page.isDisabled('#plan .primary'));
  assert.match(await page.textContent('#plan'), /musher view --link/);
  await page.goto(page.url().replace(/#.*/, '#actuators/audio'));
  await page.waitForSelector('.details');
  assert.ok(await page.isDisabled('.details button:has-text("Restart")'));
}));

test('where the emergency stop needs a login, its button says so',
  () => inPage({mayAct: false, mayStop: false}, async page => {
  assert.ok(await page.isDisabled('.stop'));
  assert.equal(await page.getAttribute('.stop', 'aria-describedby'), 'look-how');
}));

test('a fault stays after it is over, with its count in every view, until a person acknowledges it',
  () => inPage({}, async (page, {robot}) => {
  robot.fault('audio');
  await page.waitForSelector('.problem >> text=audio has crashed');
  robot.recover('audio');
  await page.waitForSelector('.wrong-card >> text=Nothing is wrong');
  await page.waitForSelector('.past .event.bad >> text=audio is degraded');
  await page.goto(page.url().replace(/#.*|$/, '#log'));
  await page.click('#top .faults');
  await page.click('button:has-text("Acknowledge")');
  await page.waitForSelector('.past', {state: 'detached'});
  await page.waitForSelector('#top .faults', {state: 'detached'});
  assert.match(await page.title(), /^robot: Active/);
  await page.reload();
  await page.waitForSelector('.wrong-card >> text=Nothing is wrong');
  assert.equal(await page.locator('.past').count(), 0, 'the next visit knows it');
  robot.fault('camera');
  await page.waitForSelector('#top .faults >> text=! 1');
}));

test('a controller that ends leaves its last report, marked; its return clears the mark',
  () => inPage({}, async (page, {robot}) => {
  robot.controllerEnds();
  await page.waitForSelector('.banner.bad >> text=The controller has ended');
  assert.match(await page.textContent('.big-state'), /Active/);
  assert.match(await page.textContent('.wrong-card'), /Not known/);
  assert.match(await page.evaluate(() => getComputedStyle(document.querySelector('main')).filter), /grayscale/);
  robot.controllerReturns();
  await page.waitForSelector('.banner.bad', {state: 'detached'});
  assert.match(await page.textContent('.wrong-card'), /Nothing is wrong/);
}));

test('a server that is silent for 3 s, and a lost connection, make the data old until it is back',
  () => inPage({}, async (page, {server}) => {
  server.silent = true;
  await page.waitForSelector('.banner.warn >> text=No data for 3');
  server.silent = false;
  await page.waitForSelector('.banner.warn', {state: 'detached'});
  server.refuse = true;
  server.drop();
  await page.waitForSelector('.banner.warn');
  server.refuse = false;
  await page.waitForSelector('.banner.warn', {state: 'detached'});
}));

test('a slow server delays answers and breaks nothing', () => inPage({}, async (page, {server, robot}) => {
  const slow = gate();
  server.delay = () => slow.opened;
  await page.click('.choice:has-text("Protected")');
  await page.waitForSelector('text=Requesting the plan');
  robot.engage('bob', 'a person is near');
  await page.waitForSelector('.banner.bad >> text=a person is near');
  slow.release();
  await page.waitForSelector('#plan');
}));

test('a restart needs a confirmation, and its end is announced', () => inPage({hash: 'actuators'},
  async (page, {server, robot}) => {
  robot.fault('camera');
  await page.waitForSelector('.actuator.bad >> text=crashed');
  await page.click('#actuator-camera');
  await page.waitForSelector('.tail pre >> text=line 300');
  await page.click('.details button:has-text("Restart")');
  await page.click('dialog .danger');
  await page.waitForSelector('#said >> text=camera is back');
  assert.deepEqual(server.requests, [{path: '/api/restart', body: {...MACHINE, actuator: 'camera'}}]);
  await until('it is well',
    async () => /well/.test(await page.textContent('tr.actuator:has-text("camera")')));
}));

test('the timeline is moved by wheel, drag, keys and buttons, and a click on a fault shows its causes',
  () => inPage({hash: 'timeline'}, async (page, {robot}) => {
  robot.fault('audio');
  await page.waitForSelector('.mark.bad');
  await screenshot(page, 'timeline', {clip: {x: 0, y: 0, width: 1280, height: 620}});
  const shown = () => page.evaluate(() => {
    const {length, to} = document.querySelector('.chart').dataset;
    return {length: Number(length), to};
  });
  const box = await page.locator('.chart').boundingBox();
  const first = await shown();
  await page.mouse.move(box.x + 500, box.y + 60);
  await page.mouse.wheel(0, -600);
  await until('the wheel zooms in', async () => (await shown()).length < first.length / 2);
  const near = await shown();
  await page.mouse.down();
  await page.mouse.move(box.x + 800, box.y + 60, {steps: 3});
  await page.mouse.up();
  await until('a drag pans', async () => (await shown()).to !== near.to && (await shown()).to !== 'now');
  assert.equal((await shown()).length, near.length);
  await page.focus('.chart');
  await page.keyboard.press('-');
  await until('a key zooms out', async () => (await shown()).length > near.length * 1.5);
  await page.click('.chart-controls button:has-text("Now")');
  await until('a button returns to the present', async () => (await shown()).to === 'now');
  await page.click('.chart-controls button:has-text("All")');
  await until('a button shows all', async () => (await shown()).length >= 900000);
  await page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
  const mark = await page.locator('.mark.bad').last().boundingBox();
  await page.mouse.click(mark.x + mark.width / 2, mark.y + mark.height / 2);
  await page.waitForSelector('.why');
  assert.match(await page.textContent('.chain'),
    /audio is degraded.*first cause.*audio's process 4103 was ended by SIGSEGV/s);
}));

test('numbers are plotted over the time of the timeline, added and removed', () => inPage({hash: 'timeline'},
  async (page, {robot}) => {
  const drawn = {state: 'attached'};  // a flat line has no height
  await page.waitForSelector('.plot:has-text("battery") .plot-line', drawn);
  await page.selectOption('#plot-add', 'cpu audio');
  await page.waitForSelector('.plot:has-text("CPU audio") .plot-line', drawn);
  robot.emit(robot.processes());
  await until('the line goes on', async () => /M.*H.*V.*H/.test(
    await page.getAttribute('.plot:has-text("CPU audio") .plot-line', 'd')));
  await page.click('.plot:has-text("CPU audio") button');
  await page.waitForSelector('.plot:has-text("CPU audio")', {state: 'detached'});
  await page.selectOption('#plot-topic', '/skill_feedback');
  await page.selectOption('#plot-field', '/skill_feedback progress');
  await page.waitForSelector('.plot:has-text("/skill_feedback progress")');
}));

test('a state machine, a tree and a skill are drawn with what is present lit',
  () => inPage({hash: 'application/wedding'}, async (page, {server, robot}) => {
  await page.waitForSelector('.node.lit >> text=WATCH');
  await screenshot(page, 'application', {clip: {x: 0, y: 0, width: 1280, height: 720}});
  robot.behavior = 'PHOTO';
  server.publishWatched('/wedding/behavior_state');
  await page.waitForSelector('.node.lit >> text=PHOTO');
  await page.click('.chooser >> text=gardener');
  await page.waitForSelector('.tree-node.s1 >> text=drive');
  robot.treeStatus = [1, 2, 1, 2, 2, 1, 0];
  server.publishWatched('/gardener/tree_state');
  await page.waitForSelector('.tree-node.s1 > p >> text=open_valve');
  await page.click('.chooser >> text=skills');
  await page.waitForSelector('.skill >> text=Driving to the goal');
  assert.equal(await page.locator('progress').first().evaluate(p => p.value), 40);
}));

test('pictures of cameras are drawn, and none is fetched when the view is left',
  () => inPage({hash: 'cameras'}, async (page, {server}) => {
  let fetched = 0;
  const picture = server.picture.bind(server);
  server.picture = (...all) => (++fetched, picture(...all));
  await until('a picture is drawn', () => page.evaluate(() => {
    const canvas = document.querySelector('canvas');
    return canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data[3] === 255;
  }));
  await page.click('nav >> text=Log');
  await page.waitForSelector('pre.log >> text=line 300');
  const before = fetched;
  await page.fill('#log-find', 'gyroscope');
  await until('the log is filtered',
    async () => !(await page.textContent('pre.log')).includes('the loop took'));
  assert.ok(fetched <= before + 2);
}));

test('a person logs in by a PIN, and ends all logins', () => inPage({mayAct: false}, async (page, {server}) => {
  await page.click('.banner >> text=Log in');
  for (const [pin, why] of [['12', 'A PIN has six digits'], ['000000', 'the PIN is wrong']]) {
    await page.fill('#pin', pin);
    await page.keyboard.press('Enter');
    await page.waitForSelector(`dialog >> text=${why}`);
  }
  await page.fill('#pin', '482 103');
  await page.click('dialog .primary');
  await page.waitForSelector('text=Acting as alice');
  await page.click('text=End all logins');
  await page.click('dialog .danger');
  await page.waitForSelector('text=Looking only');
  assert.deepEqual(server.requests.map(r => [r.path, r.body]), [['/api/logout', {all: true}]]);
}));

test('a skill is run with its parameters, and cancelled', () => inPage({hash: 'application/skills'},
  async (page, {server, robot}) => {
  await page.click('.skill:has-text("goto") >> text=Cancel');
  await until('it is cancelled', () => server.requests.length === 1);
  assert.deepEqual(server.requests[0], {path: '/api/cancel_skill', body: {...MACHINE, action: '/skill_execution', goal_id: '00'}});
  robot.skillStatus = 3;
  server.publishWatched('/skill_feedback');
  await page.waitForSelector('.skill:has-text("goto") .pill >> text=cancelled');
  const photo = '.skill:has-text("take_photo")';
  await page.click(`${photo} >> text=Run …`);
  await until('the first parameter has the focus', () => page.evaluate(() => document.activeElement.name === 'name'));
  await page.fill('[name=name]', 'full');
  await page.click(`${photo} .primary`);
  await page.waitForSelector(`${photo} >> text=Refused: the disk is full`);
  await page.fill('[name=name]', 'roses');
  await page.click(`${photo} .primary`);
  await page.waitForSelector('.skill-form', {state: 'detached'});
  assert.deepEqual(server.requests.at(-1), {path: '/api/skill', body: {...MACHINE, action: '/skill_execution',
    actuator: 'skills', skill: 'take_photo', parameters: {name: 'roses'}}});
}));

test('a run without a goal, as after a restart, is cancelled by its skill', () => inPage({hash: 'application/skills'},
  async (page, {server, robot}) => {
  robot.skillGoal = '';
  server.publishWatched('/skill_feedback');
  await page.click('.skill:has-text("goto") >> text=Cancel');
  await until('it is cancelled', () => server.requests.length === 1);
  assert.deepEqual(server.requests[0], {path: '/api/cancel_skill', body: {...MACHINE, actuator: 'skills', skill: 'goto'}});
}));

test('a skill is paused and goes on, and a refusal is said', () => inPage({hash: 'application/skills'},
  async (page, {server, robot}) => {
  const goto = '.skill:has-text("goto")';
  await page.click(`${goto} >> text=Pause`);
  await until('it is paused', () => robot.skillPaused);
  assert.deepEqual(server.requests, [{path: '/api/pause_skill', body: {...MACHINE, actuator: 'skills', skill: 'goto',
    pause: true}}]);
  await page.waitForSelector('text=goto is being paused');
  server.publishWatched('/skill_feedback');
  await page.waitForSelector(`${goto} .pill >> text=paused`);
  assert.equal(await page.locator(`${goto} >> text=Cancel`).count(), 1, 'a paused run can be cancelled');
  await page.click(`${goto} >> text=Resume`);
  await until('it goes on', () => !robot.skillPaused);
  await page.click(`${goto} >> text=Resume`);
  await page.waitForSelector('text=goto is not paused');
  server.publishWatched('/skill_feedback');
  await page.waitForSelector(`${goto} .pill >> text=running`);
  robot.skillStatus = 1;
  server.publishWatched('/skill_feedback');
  await page.waitForSelector(`${goto} .pill >> text=completed`);
  assert.equal(await page.locator(`${goto} >> text=Pause`).count(), 0, 'only a run is paused');
}));

test('several logs are one by time, of a level and above', () => inPage({hash: 'log'}, async page => {
  await page.waitForSelector('pre.log >> text=line 300');
  await page.click('.log-chooser summary');
  await page.click('.log-chooser button:has-text("audio")');
  await page.waitForSelector('pre.log >> text=audio | ');
  const lines = (await page.textContent('pre.log')).split('\n');
  assert.equal(lines.length, 600);
  assert.deepEqual(lines.slice(-2).map(line => line.split(' | ')[0]), ['controller', 'audio']);
  await page.selectOption('#log-level', 'warning');
  await until('only warnings', async () => (await page.textContent('pre.log')).split('\n')
    .every(line => line.includes('warning: the gyroscope')));
}));

test('of a large machine the neighbourhood of the present state is drawn, and in view on a phone',
  () => inPage({hash: 'robot', width: 390, height: 844}, async (page, {server, robot}) => {
  robot.large = true;
  robot.behavior = 'SECTION_17';
  await page.goto(page.url().replace(/#.*/, '#application/wedding'));
  await page.waitForSelector('.node.lit >> text=SECTION_17');
  assert.deepEqual((await page.locator('.node text').allTextContents()).sort(),
    ['SECTION_0', 'SECTION_16', 'SECTION_17', 'SECTION_18']);
  assert.match((await page.locator('.graph .label').allTextContents()).join(), /the line is passed \(\+1\)/);
  const inView = async () => {
    const lit = await page.locator('.node.lit rect').boundingBox();
    const box = await page.locator('.graph').first().boundingBox();
    return lit.x >= box.x && lit.x + lit.width <= box.x + box.width;
  };
  await until('the present state is in view', inView);
  await page.click('text=Show all 40 states');
  await until('all states are drawn', async () => (await page.locator('.node').count()) === 40);
  await until('the present state is in view', inView);
  robot.behavior = 'SECTION_3';
  server.publishWatched('/wedding/behavior_state');
  await page.waitForSelector('.node.lit >> text=SECTION_3');
  await until('the next present state is in view', inView);
}));

test('of a large tree the branches that are finished or idle are folded and say so', () => inPage({}, async (page, {robot}) => {
  const branch = (name, parent) => ({name, type: 'Sequence', kind: 'Control', parent});
  const leaves = (name, parent) => Array.from({length: 9}, (_, i) => ({name: `${name}${i}`, type: 'Step', kind: 'Action',
    parent}));
  const nodes = [branch('Tour', -1), branch('Greet', 0), branch('Walk', 0), branch('Part', 0), ...leaves('greet', 1),
    ...leaves('walk', 2), ...leaves('part', 3)];
  const status = [1, 2, 1, 0, ...Array(9).fill(2), 1, ...Array(17).fill(0)];
  robot.tree = () => ({error: '', state: {tree: 'Tour', revision: 1, ticking: true, ticks: 9, time_s: 4, status,
    last_fault: ''}, nodes});
  await page.goto(page.url().replace(/#.*/, '#application/gardener'));
  await page.waitForSelector('.tree >> text=walk8');
  assert.deepEqual(await page.locator('.tree summary').allTextContents(),
    ['finished; 9 nodes inside', 'does not run; 9 nodes inside']);
  assert.equal(await page.locator('text=greet0').isVisible(), false);
  await page.click('.tree summary >> nth=0');
  assert.equal(await page.locator('text=greet0').isVisible(), true);
}));

test('a camera that gives no picture in LowPower is off, not loading', () => inPage({}, async (page, {server, robot}) => {
  server.dark = true;
  robot.state = 'LowPower';
  robot.publish();
  await page.click('nav >> text=Cameras');
  await page.waitForSelector('.pictures >> text=off in LowPower');
  await until('no camera loads for ever', async () => !/Loading/.test(await page.textContent('main')));
}));

test('advice to switch again is a button that shows the plan', () => inPage({}, async (page, {robot}) => {
  robot.status = (status => () => ({...status(), held_by_stop: ['audio']}))(robot.status.bind(robot));
  robot.publish();
  await page.click('.problem button:has-text("Switch to Active again")');
  await page.waitForSelector('#plan');
}));

test('no text has raw backquotes', () => inPage({}, async (page, {robot}) => {
  robot.fault('audio', {message: 'crashed; `musher logs audio` shows why'});
  await page.waitForSelector('.problem code >> text=musher logs audio');
  for (const view of [...VIEWS, 'actuators/audio', 'timeline/why/audio', 'robot']) {
    await page.goto(page.url().replace(/#.*/, `#${view}`));
    await page.waitForSelector('.card');
    assert.doesNotMatch(await page.textContent('body'), /`/, view);
  }
  await page.click('.choice:has-text("TearDown")');
  await page.waitForSelector('#plan code >> text=musher up');
}));

test('what the robot says is text, never HTML', () => inPage({}, async (page, {robot}) => {
  const evil = '<img src=x onerror="globalThis.evil = 1"><b>bold</b>';
  robot.fault('audio', {message: evil});
  robot.engage(evil, evil);
  await page.waitForSelector('.problem >> text=<b>bold</b>');
  for (const view of ['actuators', 'timeline/why/audio']) {
    await page.goto(page.url().replace(/#.*/, `#${view}`));
    await page.waitForSelector('main >> text=<b>bold</b>');
  }
  assert.equal(await page.evaluate(() => globalThis.evil), undefined);
}));

for (const locale of ['zh-CN', 'en']) test(`every view fits 390 px, with targets of 44 px for what acts: ${locale}`,
  () => inPage({width: 390, height: 844, locale, dark: true}, async (page, {robot}) => {
  robot.fault('audio');
  await page.waitForSelector('.problem');
  if (locale !== 'en') await screenshot(page, 'phone');
  for (const view of VIEWS) {
    await page.goto(page.url().replace(/#.*/, `#${view}`));
    await page.waitForSelector('.card');
    const apart = await page.evaluate(() => [...document.querySelectorAll('nav a')].map(a => {
      const text = document.createRange();
      text.selectNodeContents(a);
      return text.getBoundingClientRect();
    }).filter(r => r.width > 0).every((r, i, all) => i === 0 || r.left - all[i - 1].right >= 10));
    assert.ok(apart, `${view}: the tabs run together`);
    const [scroll, inner] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(scroll <= inner, `${view}: ${scroll} px in ${inner}`);
    const small = await page.evaluate(() => [...document.querySelectorAll('button, select, nav a, a.button')]
      .map(e => [e.textContent.slice(0, 20), e.getBoundingClientRect()]).filter(([, r]) => r.height > 0
        && (r.height < 43.5 || r.width < 40))
      .map(([name, r]) => `${name} ${r.width}x${r.height}`));
    assert.deepEqual(small, [], view);
  }
  const stop = await page.locator('.stop').boundingBox();
  await page.evaluate(() => scrollTo(0, 1e6));
  assert.deepEqual(await page.locator('.stop').boundingBox(), stop);
}));

for (const [name, options] of Object.entries({'light and English': {},
  'dark and Chinese on a phone': {dark: true, locale: 'zh-CN', width: 390},
  'without the login': {mayAct: false, dark: true}})) {
  test(`axe finds nothing in any view: ${name}`, () => inPage(options, async (page, {robot}) => {
    robot.fault('audio');
    robot.engage('bob', 'a person is near');
    await page.waitForSelector('.problem');
    const found = [];
    for (const view of [...(options.mayAct === false ? ['robot'] : VIEWS), 'actuators/audio', 'timeline/why/audio']) {
      await page.goto(page.url().replace(/#.*/, `#${view}`));
      await page.waitForSelector(view.startsWith('application/w') ? '.node' : view.includes('why') ? '.why'
        : '.card');
      found.push(...(await axeViolations(page)).map(v => `${view}: ${v}`));
    }
    await page.goto(page.url().replace(/#.*/, '#robot'));
    await page.click('.choice:has-text("LowPower")');
    await page.waitForSelector('#plan');
    found.push(...(await axeViolations(page)).map(v => `plan: ${v}`));
    assert.deepEqual(found, []);
  }));
}

test('a switch and an emergency stop need only the keyboard, and the focus is always seen',
  () => inPage({}, async (page, {server, robot}) => {
  const tabTo = async text => {
    for (let i = 0; i < 60; ++i) {
      await page.keyboard.press('Tab');
      const focus = await page.evaluate(() => [document.activeElement.textContent,
        getComputedStyle(document.activeElement).outlineStyle]);
      assert.notEqual(focus[1], 'none', `the focus on ${focus[0]} is invisible`);
      if (focus[0].includes(text)) return;
    }
    assert.fail(`Tab does not reach ${text}`);
  };
  await tabTo('LowPower');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#plan .primary');
  await tabTo('Switch to LowPower');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.outcome.ok');
  await page.waitForSelector('#said >> text=Done: the robot is in LowPower');
  await page.focus('.language');
  await tabTo('STOP');
  await page.keyboard.press('Space');
  await until('the stop is engaged', () => robot.stop);
  assert.equal(server.requests.at(-1).path, '/api/estop');
}));

for (const denied of ['refused',
  'closed']) test(`a page whose WebSocket is ${denied} says how to get the login, and works once it may`,
  () => inPage({denied}, async (page, {server}) => {
  await page.waitForSelector('.banner >> text=From another computer, looking needs a login');
  server.denied = false;
  await page.waitForSelector('.card');
  await page.waitForSelector('.banner.warn', {state: 'detached'});
}));

test('causes from before the history that the server sends are fetched',
  () => inPage({}, async (page, {server, robot}) => {
  const first = robot.history[0];
  server.older = [{...first, id: 9001, cause: 0, wall_ns: String(BigInt(first.wall_ns) - 10n ** 9n),
    message: 'the cable was loose'}];
  robot.record('actuator_crashed', 'world is degraded: no data',
    {actuator: 'world', code: 1105, cause: 9001});
  await page.waitForSelector('.event >> text=world is degraded: no data');
  await page.click('.event >> text=world is degraded: no data');
  await page.waitForSelector('.chain >> text=the cable was loose');
  assert.match(await page.textContent('.chain'), /first cause/);
}));

test('the chosen language is kept', () => inPage({}, async page => {
  await page.click('.language');
  await page.waitForSelector('nav >> text=时间线');
  await page.reload();
  await page.waitForSelector('nav >> text=时间线');
  assert.equal(await page.evaluate(() => document.documentElement.lang), 'zh-CN');
}));
