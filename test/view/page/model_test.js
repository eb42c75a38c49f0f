// The page without a browser: what messages mean, what the timeline draws, how a state machine is laid out.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync, statSync} from 'node:fs';
import path from 'node:path';
import {test} from 'node:test';
import {applicationsOf} from '../../../view/page/application.js';
import {camerasOf} from '../../../view/page/cameras.js';
import {chartsWithPresent, joined, neighbourhood, readChart} from '../../../view/page/chart_text.js';
import {Connection, post} from '../../../view/page/connection.js';
import {ANSWER_MS} from '../../../view/page/estop.js';
import {bytes, duration, nsToMs, percent} from '../../../view/page/format.js';
import {layOut} from '../../../view/page/graph_layout.js';
import {chosenLines, merged, readLines} from '../../../view/page/log_lines.js';
import {MOST_POINTS, numbersOf, shownOf, switchTimes, withPoint} from '../../../view/page/plots_model.js';
import {readParameter} from '../../../view/page/skills.js';
import {allTexts, chooseLanguage} from '../../../view/page/i18n.js';
import * as store from '../../../view/page/store.js';
import {lanesOf, panned, spansOf, ticks, zoomed} from '../../../view/page/timeline_model.js';
import {chainOf, eventToExplain} from '../../../view/page/why.js';
import {MockRobot} from './mock_robot.js';
import {PAGE} from './mock_server.js';

// A robot whose messages go into a store; `now` is the clock of both.
function fixture() {
  const f = {now: 1780000000000, state: store.initialState()};
  f.robot = new MockRobot(message => (f.state = store.apply(f.state, message, f.now)), f.now);
  f.robot.nowMs = () => f.now;
  f.state = store.initialState();
  const send = message => (f.state = store.apply(f.state, message, f.now));
  f.send = send;
  send({op: 'link', link: 'open'});
  send({op: 'hello', version: '0', namespace: '', may_act: true, who: 'test', time_ms: f.now});
  f.robot.greeting().forEach(send);
  return f;
}

test('a state that was handed out never changes', () => {
  const f = fixture();
  const before = JSON.stringify(f.state);
  const held = f.state;
  f.robot.fault('audio');
  f.robot.engage('a', 'b');
  assert.equal(JSON.stringify(held), before);
  assert.notEqual(JSON.stringify(f.state), before);
});

test('a server that is silent for more than 3 s makes the data old, and its next message makes it live',
  () => {
  const f = fixture();
  assert.equal(store.freshness(f.state, f.now + 3000), 'live');
  assert.equal(store.freshness(f.state, f.now + 3001), 'old');
  f.now += 5000;
  f.send({op: 'time', time_ms: f.now});
  assert.equal(store.freshness(f.state, f.now), 'live');
  f.send({op: 'link', link: 'closed', retryAt: f.now});
  assert.equal(store.freshness(f.state, f.now), 'old');
});

test('a controller that ended is gone until it publishes again', () => {
  const f = fixture();
  f.robot.controllerEnds();
  assert.equal(store.freshness(f.state, f.now), 'gone');
  assert.equal(store.statusOf(f.state).state, 'Active');
  f.robot.controllerReturns();
  assert.equal(store.freshness(f.state, f.now), 'live');
});

test('a robot without faults has no problems; the worst problem is first', () => {
  const f = fixture();
  assert.deepEqual(store.problems(f.state), []);
  f.robot.policy.battery_silent = true;
  f.robot.fault('audio');
  f.robot.fault('world', {health: 'hung', message: 'hung: no progress'});
  const list = store.problems(f.state);
  assert.deepEqual(list.map(p => [p.id, p.level, p.what]), [['actuator world', 'bad', 'problem.hung'],
    ['actuator audio', 'warn', 'problem.crashed'], ['battery_silent', 'warn', 'problem.battery_silent']]);
  assert.equal(list[0].why, 'hung: no progress');
  f.robot.engage('bob', 'smoke');
  assert.equal(store.problems(f.state)[0].id, 'stop');
});

test('rules of the user that are violated need attention until they hold', () => {
  const f = fixture();
  f.robot.violatedRules = ['never lamp Active while base is not Active', 'never lamp Error'];
  f.robot.fault('audio');
  const rule = store.problems(f.state).find(p => p.id === 'rule');
  assert.equal(rule.level, 'warn');
  assert.equal(rule.why, 'never lamp Active while base is not Active; never lamp Error');
  f.robot.violatedRules = [];
  f.robot.fault('audio');
  assert.ok(!store.problems(f.state).some(p => p.id === 'rule'));
});

test('an actuator that has not stopped at a stop is the first thing after it', () => {
  const f = fixture();
  f.robot.notStopped = ['audio: the brake does not answer'];
  f.robot.engage('bob', 'smoke');
  const [stop, not_stopped] = store.problems(f.state);
  assert.equal(stop.id, 'stop');
  assert.equal(not_stopped.id, 'not_stopped');
  assert.equal(not_stopped.level, 'bad');
  assert.equal(not_stopped.why, 'audio: the brake does not answer');
});

test('every problem and its advice have a text', () => {
  const f = fixture();
  f.robot.notStopped = ['audio: the brake does not answer'];
  f.robot.engage('bob', 'smoke');
  Object.assign(f.robot.policy, {battery_silent: true, ceiling: 'Protected', power: 'reboot'});
  f.robot.violatedRules = ['never lamp Error'];
  for (const health of ['hung', 'starved', 'crashed', 'partitioned']) {
    f.robot.fault('audio', {health});
    f.robot.fault('camera', {health: 'well', message: 'has not passed its self-check'});
    for (const p of store.problems(f.state)) {
      assert.ok(p.what in allTexts(), p.what);
      assert.ok(`advice.${p.advice}` in allTexts(), p.advice);
    }
  }
});

test('a status of an older or a newer controller does not break the page', () => {
  let state = store.apply(store.initialState(), {op: 'something new', x: 1}, 5);
  state = store.apply(state, {op: 'latest', topic: '/a/musher/machine_status', type: 'x', received_ms: 1,
    message: {state: 'Active', phase: 'running'}}, 6);
  assert.deepEqual(store.problems(state), []);
  assert.ok(store.offeredStates(state).includes('Active'));
});

test('states of the config that were seen are offered beside the built-in ones', () => {
  const f = fixture();
  assert.ok(!store.offeredStates(f.state).includes('Parked'));
  f.robot.record('switch_done', 'switch 9 is done', {state: 'Parked'});
  assert.ok(store.offeredStates(f.state).includes('Parked'));
  assert.equal(new Set(store.offeredStates(f.state)).size, store.offeredStates(f.state).length);
});

test('an entry that is sent twice stands once in the history; a reset replaces all', () => {
  const f = fixture();
  const count = f.state.history.length;
  f.send({op: 'history', reset: false, entries: [f.robot.history.at(-1)]});
  assert.equal(f.state.history.length, count);
  f.send({op: 'history', reset: true, entries: [f.robot.history.at(-1)]});
  assert.equal(f.state.history.length, 1);
});

test('64-bit times keep their millisecond', () => {
  assert.equal(Math.round(nsToMs('1780000000123456789') * 1000) / 1000, 1780000000123.457);
  assert.equal(nsToMs(1500000), 1.5);
});

test('lengths, bytes and shares are readable', () => {
  assert.deepEqual([0, 999, 1000, 59999, 61000, 3.7e6, 1e8].map(duration),
    ['0 ms', '999 ms', '1.0 s', '59 s', '1 min 01 s', '1 h 01 min', '1 d 3 h']);
  assert.deepEqual([0, 999, 1500, 21e6, 999.9e6, undefined].map(bytes),
    ['0 B', '999 B', '1.5 kB', '21 MB', '1.0 GB', '–']);
  assert.deepEqual([0, 3.21, 99.6, NaN].map(percent), ['0.0 %', '3.2 %', '100 %', '–']);
});

test('the timeline has the states of the history, and those that were observed', () => {
  const f = fixture();
  f.now += 1000;
  f.robot.fault('audio');
  f.now += 1000;
  f.robot.recover('audio');
  const {lanes} = lanesOf(f.state.history, f.state.observed, ['audio', 'world']);
  assert.deepEqual(lanes.map(l => l.name), ['', 'audio', 'world']);
  assert.equal(lanes[1].changes.at(-1).state, 'Active');
  assert.ok(lanes[1].changes.some(c => c.state === 'lost' && c.ms === f.now - 1000));
  assert.deepEqual(lanes[0].changes.map(c => c.state), ['SelfCheck', 'Active', 'LowPower', 'Active']);
  const spans = spansOf(lanes[0].changes, f.now);
  assert.equal(spans.at(-1).to, f.now);
  assert.ok(spans.every((s, i) => i === 0 || s.from === spans[i - 1].to));
  assert.ok(lanes[1].marks.every(m => m.entry.actuator === 'audio'));
});

test('an emergency stop lasts from its first engagement to its release', () => {
  const f = fixture();
  f.robot.engage('a', 'x');
  f.now += 500;
  f.robot.engage('b', 'y');
  f.now += 500;
  assert.deepEqual(lanesOf(f.state.history, {}, []).stops, [{from: f.now - 1000, to: null}]);
  f.robot.release('a');
  assert.deepEqual(lanesOf(f.state.history, {}, []).stops, [{from: f.now - 1000, to: f.now}]);
});

test('zooming keeps the time under the pointer, and has limits', () => {
  const window = {from: 1000, to: 2000};
  const near = zoomed(window, 0.5, 1250);
  assert.deepEqual(near, {from: 1125, to: 1625});
  assert.ok(zoomed(window, 1e-9, 1500).to - zoomed(window, 1e-9, 1500).from >= 500);
  assert.deepEqual(panned(window, -0.5), {from: 500, to: 1500});
});

test('an axis has at most as many times as asked for, all inside', () => {
  for (const length of [700, 9e3, 61e3, 3.6e6, 8.64e7, 3e9]) {
    const {list} = ticks(1780000000000, 1780000000000 + length, 8);
    assert.ok(list.length > 0 && list.length <= 9, String(length));
    assert.ok(list.every(at => at >= 1780000000000 && at <= 1780000000000 + length));
  }
});

const badOf = f => f.state.history.findLast(entry => store.levelOf(entry) === 'bad');
// What a person sees as acknowledged after a click now, with what was acknowledged before.
const acknowledge = (f, before = {}) => ({...before, ...store.acknowledgement(f.state)});
const recent = (f, acknowledged, at = f.now) => store.recentFaults(f.state, at, acknowledged);

test('a fault is recent for ten minutes, or until it is acknowledged', () => {
  const f = fixture();
  f.robot.fault('audio');
  const fault = badOf(f);
  const at = fault.ms - f.state.offset;
  assert.deepEqual(recent(f, {}, at)[0], fault);
  assert.deepEqual(recent(f, acknowledge(f), at), []);
  assert.deepEqual(recent(f, {}, at + store.FAULTS_STAY_MS), []);
});

test('the store shows a fault after an acknowledgement, also where the clock of the robot has gone back by hours', () => {
  const f = fixture();
  f.robot.fault('audio');
  const acknowledged = acknowledge(f);
  f.robot.epoch += 1;
  f.robot.nextId = 1;
  f.now -= 3 * 3600_000;
  f.send({op: 'time', time_ms: f.now});
  assert.deepEqual(recent(f, acknowledged), []);
  f.robot.fault('camera');
  assert.deepEqual(recent(f, acknowledged), [badOf(f)]);
  assert.deepEqual(recent(f, acknowledge(f, acknowledged)), [], 'the second acknowledgement is kept');
});

test('a fault after an acknowledgement is shown that has neither epoch nor id, as recorded before a controller leads', () => {
  const f = fixture();
  f.robot.fault('audio');
  const acknowledged = acknowledge(f);
  f.now += 1000;
  f.send({op: 'history', reset: false, entries: [{...f.robot.history.at(-1), epoch: 0, id: 0, code: 100, event: '',
    wall_ns: String(f.now * 1e6)}]});
  assert.deepEqual(recent(f, acknowledged), [f.state.history.at(-1)]);
  assert.deepEqual(recent(f, acknowledge(f, acknowledged)), []);
});

test('a fault after an acknowledgement is shown, also where the epochs begin again', () => {
  const f = fixture();
  f.robot.fault('audio');
  const acknowledged = acknowledge(f);
  f.robot.epoch = 1;
  f.robot.nextId = 1;
  f.robot.fault('camera');
  assert.deepEqual(recent(f, acknowledged)[0], badOf(f));
});

test('an acknowledgement on one machine hides no fault of another', () => {
  const f = fixture();
  f.robot.fault('audio');
  const {epoch, id} = badOf(f);
  assert.deepEqual(recent(f, {other: {epoch: epoch + 1, id: id + 1, ms: f.now + 1}})[0], badOf(f));
  assert.deepEqual(Object.keys(acknowledge(f)), [store.shownMachine(f.state).machine_id]);
});

test('a fault without an id, as the journal records it, can be acknowledged', () => {
  const f = fixture();
  f.robot.fault('audio');
  f.send({op: 'history', reset: false, entries: [{...f.robot.history.at(-1), id: 0, code: 100, event: '',
    wall_ns: String(f.now * 1e6)}]});
  assert.equal(recent(f, {})[0].id, 0);
  assert.deepEqual(recent(f, acknowledge(f)), []);
});

test('the front camera is first, a depth image and the back camera are last', () => {
  const topics = ['/back/color', '/front/depth', '/left/image', '/front/color', '/front/image', '/head/color']
    .map(name => ({name, type: 'sensor_msgs/msg/Image', publishers: 1}));
  assert.deepEqual(camerasOf(topics), ['/front/color', '/front/image', '/head/color', '/left/image', '/front/depth',
    '/back/color']);
  assert.deepEqual(camerasOf([{...topics[0], publishers: 0}]), []);
});

test('the skills of four robots, which are samples of one topic, are four applications', () => {
  const f = fixture();
  for (const actuator of ['ann', 'ben', 'cid', 'dot']) {
    f.send({op: 'latest', topic: '/skills', type: 'musher_msgs/msg/SkillOffers', received_ms: f.now,
      message: {actuator, action: `/${actuator}/skill_execution`, skills: [{skill: 'goto', parameters: []}]}});
  }
  assert.deepEqual(applicationsOf([], f.state.offers).map(a => [a.name, a.skills]),
    ['ann', 'ben', 'cid', 'dot'].map(name => [name, true]));
});

test('a parameter of a skill says its name, and whether it is needed', () => {
  assert.deepEqual(readParameter('altitude_m: number, default 1, 0.2 to 10'),
    {name: 'altitude_m', hint: 'number, default 1, 0.2 to 10', required: false});
  assert.deepEqual(readParameter('x_m: number, required'), {name: 'x_m', hint: 'number, required', required: true});
});

test('lines of logs have a level and the time of the line before them', () => {
  const lines = readLines('2026-03-01 13:00:05.250 audio: warning: hot\n  #0 Play()\nplain\n'
    + '[1717.5] [ERROR] [node]: broken\n2026-03-01T13:00:06.000 audio: plays\n', 'audio');
  assert.deepEqual(lines.map(line => [line.time.slice(11), line.level]), [['13:00:05.250', 'warning'],
    ['13:00:05.250', 'warning'], ['13:00:05.250', 'info'], ['13:00:05.250', 'error'], ['13:00:06.000', 'info']]);
  const other = readLines('2026-03-01 13:00:05.300 motion: error: stuck\n', 'motion');
  assert.deepEqual(chosenLines(merged([lines, other]), {level: 'error', several: true}),
    ['audio | [1717.5] [ERROR] [node]: broken', 'motion | 2026-03-01 13:00:05.300 motion: error: stuck']);
  assert.deepEqual(chosenLines(lines, {find: 'PLAIN'}), ['plain']);
  assert.deepEqual(readLines('', 'x'), []);
});

test('parallel arrows are one, and of a large chart the neighbourhood stays', () => {
  const chart = readChart(new MockRobot().largeBehavior(), 'race');
  const {chart: near, folded} = neighbourhood(chart, 'SECTION_17', 12);
  assert.deepEqual(near.states.map(s => s.name), ['SECTION_0', 'SECTION_16', 'SECTION_17', 'SECTION_18']);
  assert.equal(folded, 36);
  assert.deepEqual(joined(near).arrows.map(a => a.text).sort(),
    ['lost', 'the line is passed (+1)', 'the line is passed (+1)']);
  assert.equal(neighbourhood(chart, 'SECTION_17', 40).folded, 0);
  const hub = neighbourhood(chart, '', 12).chart;
  assert.equal(hub.states.length, 12, 'every section leads to the start');
  assert.ok(hub.states.some(s => s.name === 'SECTION_1'), 'where it leads comes first');
});

test('a chain of causes ends at the first cause, or says that it is incomplete', () => {
  const f = fixture();
  f.robot.fault('audio');
  const entry = eventToExplain(f.state.history, 'audio');
  assert.equal(entry.event, 'actuator_crashed');
  assert.equal(store.levelOf(entry), 'bad');
  const {chain, complete} = chainOf(f.state.history, entry);
  assert.deepEqual(chain.map(e => e.event), ['actuator_crashed', 'process_exited']);
  assert.equal(complete, true);
  assert.equal(chainOf([entry], entry).complete, false);
  const circle = [{...entry, id: 1, cause: 2}, {...entry, id: 2, cause: 1}];
  assert.equal(chainOf(circle, circle[0]).chain.length, 2);
});

test('the state of the machine is explained by the event that changed it', () => {
  const f = fixture();
  assert.equal(eventToExplain(f.state.history, '').message, 'switch 3 is done');
  assert.equal(eventToExplain([], ''), null);
});

test('a diagram with states inside of states is read with its present states', () => {
  const chart = readChart('stateDiagram-v2\n  state "A #34;x#34;" as s0\n  state "B" as s1 {\n    state "C" as s1_0\n    [*] --> s1_0\n  }\n'
    + '  [*] --> s0\n  s0 --> s1 : go#58; now\n  s1 --> [*]\n  classDef safe stroke:#b22222\n  class s0 safe\n', 'app');
  assert.deepEqual(chart.states.map(s => [s.name, s.safe, s.final]),
    [['A "x"', true, false], ['B', false, true]]);
  assert.deepEqual(chart.arrows, [{from: 's0', to: 's1', text: 'go: now'}]);
  assert.equal(chart.start, 's0');
  assert.deepEqual(chartsWithPresent(chart, 'B/C').map(p => [p.chart.name, p.present]),
    [['app', 'B'], ['B', 'C']]);
  assert.equal(readChart('digraph {}'), null);
});

test('the diagrams that the robot writes are read: those that its own test expects', () => {
  const source = readFileSync(path.resolve(PAGE, '../../test/behavior/fsm/graph_test.cpp'), 'utf8');
  const text = /PHOTO\/CONFIRM"\), R"\((stateDiagram-v2.*?)\)"\)/s.exec(source)[1];
  const chart = readChart(text, 'show');
  assert.deepEqual(chart.states.map(s => s.name), ['IDLE', 'PHOTO', 'SAFE_STOP']);
  assert.deepEqual(chart.states[1].inside.states.map(s => [s.name, s.final]),
    [['CONFIRM', false], ['DONE', true]]);
  assert.deepEqual(chart.arrows.map(a => a.text), ['a heart is seen', 'finished', 'again', '']);
  assert.equal(chart.states[2].safe, true);
  const none = readChart('stateDiagram-v2\n', 'none');
  assert.deepEqual(layOut(none), {width: 0, height: 0, states: [], arrows: []});
});

test('states and texts of a layout never overlap, for random charts', () => {
  let seed = 7;
  const random = below => (seed = (seed * 1103515245 + 12345) % 2147483648) % below;
  for (let round = 0; round < 60; ++round) {
    const states = Array.from({length: 1 + random(12)},
      (_, i) => ({id: `s${i}`, name: `STATE_${'X'.repeat(random(9))}`}));
    const arrows = Array.from({length: random(20)}, () => ({from: `s${random(states.length)}`,
      to: `s${random(states.length)}`, text: random(2) ? 'a condition' : ''}));
    const laid = layOut({states, arrows, start: 's0'});
    const boxes = [...laid.states.map(s => ({x: s.x - s.width / 2, y: s.y - s.height / 2, w: s.width,
      h: s.height})),
      ...laid.arrows.filter(a => a.label).map(a => ({x: a.label.x - 38, y: a.label.y - 7, w: 76, h: 14}))];
    for (const [i, a] of boxes.entries()) {
      assert.ok(a.x >= 0 && a.x + a.w <= laid.width && a.y >= 0 && a.y + a.h <= laid.height,
        `round ${round}`);
      for (const b of boxes.slice(i + 1)) {
        assert.ok(a.x + a.w <= b.x + 0.01 || b.x + b.w <= a.x + 0.01 || a.y + a.h <= b.y || b.y + b.h <= a.y,
          `round ${round}`);
      }
    }
  }
});

// setTimeout() by hand: the timers of Node.js 18 and 20 that are mocked differ.
class FakeClock {
  now = 0;
  timers = [];
  setTimeout = (callback, pause) => this.timers.push({at: this.now + pause, callback});
  tick(pause) {
    this.now += pause;
    const due = this.timers.filter(timer => timer.at <= this.now);
    this.timers = this.timers.filter(timer => timer.at > this.now);
    for (const timer of due) timer.callback();
  }
}

test('a lost connection is opened again after growing pauses; a message resets them', context => {
  const clock = new FakeClock();
  const real = globalThis.setTimeout;
  globalThis.setTimeout = clock.setTimeout;
  context.after(() => {
    globalThis.setTimeout = real;
  });
  const sockets = [];
  const links = [];
  const connection = new Connection(m => m.op === 'link' && links.push(m.link),
    {make: () => (sockets.push({readyState: 0, sent: [], send(text) {
    this.sent.push(text);
  }}), sockets.at(-1)), now: () => 0});
  connection.watch(['/a']);
  sockets[0].onclose();
  clock.tick(249);
  assert.equal(sockets.length, 1);
  clock.tick(1);
  assert.equal(sockets.length, 2);
  sockets[1].onclose();
  clock.tick(499);
  assert.equal(sockets.length, 2);
  clock.tick(1);
  sockets[2].onopen();
  assert.deepEqual(sockets[2].sent, ['{"op":"watch","topics":["/a"]}']);
  sockets[2].onmessage({data: '{"op":"time"}'});
  sockets[2].onmessage({data: 'no json'});
  sockets[2].onclose();
  clock.tick(250);
  assert.equal(sockets.length, 4);
  assert.deepEqual(links.slice(0, 3), ['connecting', 'closed', 'connecting']);
});

test('the numbers of a message have their paths; texts have none, and true is 1', () => {
  assert.deepEqual(numbersOf({a: {b: 1.5}, c: [2, 'x', 3], d: 'y', e: true, f: null}),
    {'a.b': 1.5, 'c.0': 2, 'c.2': 3, e: 1});
  assert.equal(Object.keys(numbersOf({ranges: Array(5000).fill(1)})).length, 200);
  assert.deepEqual(numbersOf(undefined), {});
});

test('points of a plot become sparser instead of many, and keep the first time and the last value', () => {
  let points = [];
  for (let i = 0; i < 3 * MOST_POINTS; ++i) points = withPoint(points, i, i);
  assert.ok(points.length <= MOST_POINTS);
  assert.equal(points.at(-1).value, 3 * MOST_POINTS - 1);
  assert.ok(points[0].ms < 10);
});

test('a plot shows the points of its time, and the value that held when it began', () => {
  const points = [1, 2, 3, 4].map(n => ({ms: n * 1000, value: n}));
  assert.deepEqual(shownOf(points, {from: 2500, to: 3500}), {points: points.slice(1, 3), least: 2, most: 3, last: 3});
  assert.deepEqual(shownOf(points, {from: 9000, to: 9500}).points, [points[3]]);
  assert.equal(shownOf(points, {from: 0, to: 500}), null);
  assert.equal(shownOf([], {from: 0, to: 500}), null);
});

test('a switch takes the time from its start to its end, also when it is undone; one of another controller none', () => {
  const entry = (event, ms, switch_number, epoch = 1) => ({event, ms, switch_number, epoch});
  assert.deepEqual(switchTimes([entry('switch_started', 100, 2), entry('switch_done', 350, 2),
    entry('switch_started', 400, 3), entry('switch_undone', 900, 3), entry('switch_started', 1000, 4),
    entry('switch_done', 2000, 4, 2)]), [{ms: 350, value: 250}, {ms: 900, value: 500}]);
});

test('battery, CPU and memory are kept, and of topics the numbers that are plotted', () => {
  const f = fixture();
  assert.equal(f.state.numbers.battery.at(-1).value, store.statusOf(f.state).policy.battery);
  assert.equal(f.state.numbers['cpu audio'].length, 1);
  f.now += 1000;
  f.send(f.robot.processes());
  assert.deepEqual(f.state.numbers['memory audio'].map(p => p.ms), [f.now - 1000, f.now]);
  const imu = value => f.send({op: 'latest', topic: '/imu', type: 'sensor_msgs/msg/Imu', received_ms: f.now,
    message: {linear: {x: value, y: 2}}});
  imu(1);
  assert.equal(f.state.numbers['/imu linear.x'], undefined);
  f.send({op: 'plot', ids: ['battery', '/imu linear.x']});
  imu(3);
  assert.deepEqual(f.state.numbers['/imu linear.x'], [{ms: f.now, value: 3}]);
  assert.equal(f.state.numbers['/imu linear.y'], undefined);
});

test('the language is the stored one, else the first that the browser prefers, else English', () => {
  assert.equal(chooseLanguage('zh', ['en']), 'zh');
  assert.equal(chooseLanguage('xx', ['fr', 'zh-TW', 'en']), 'zh');
  assert.equal(chooseLanguage(null, ['fr']), 'en');
  assert.equal(chooseLanguage(undefined, undefined), 'en');
});

const sources = readdirSync(PAGE).filter(name => /\.(js|css|html|svg)$/.test(name));
const text = name => readFileSync(path.join(PAGE, name), 'utf8');

test('every text exists in both languages with the same values, and every key that the code names exists',
  () => {
  const values = s => (s.match(/\{\w+\}/g) ?? []).sort().join();
  for (const [key, pair] of Object.entries(allTexts())) {
    assert.equal(pair.length, 2, key);
    assert.ok(pair.every(s => s.length > 0), key);
    assert.equal(values(pair[0]), values(pair[1]), key);
  }
  for (const name of sources) {
    for (const [, key] of text(name).matchAll(/\bt\('([\w.]+)'/g)) assert.ok(key in allTexts(),
      `${name}: ${key}`);
  }
});

test('the page is below 181 kB, writes no HTML from data, and names no other address', () => {
  let total = 0;
  for (const name of sources) {
    total += statSync(path.join(PAGE, name)).size;
    assert.doesNotMatch(text(name), /innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(/, name);
    assert.doesNotMatch(text(name).replaceAll('http://www.w3.org/', ''), /https?:\/\/[a-z]/, name);
  }
  console.log(`the page: ${total} bytes in ${sources.length} files`);
  assert.ok(total < 181000);
});

test('the page waits longer for the answer to an emergency stop than the server for what it says', () => {
  const header = readFileSync(path.resolve(PAGE, '../live/robot_requests.hpp'), 'utf8');
  const seconds = Number(/kStopTime = std::chrono::seconds\((\d+)\)/.exec(header)[1]);
  assert.ok(ANSWER_MS >= seconds * 1000 + 1000, `${ANSWER_MS} ms`);
});

test('a request that acts names the machine on the page', () => {
  const f = fixture();
  const {machine, machine_id} = f.robot.status();
  assert.deepEqual(store.shownMachine(f.state), {machine, machine_id});
  assert.deepEqual(store.shownMachine(store.initialState()), {machine: '', machine_id: ''});
});

test('a request has the newest time of the server that the page has received, so that the server knows its age',
  async context => {
  const bodies = [];
  context.mock.method(globalThis, 'fetch', async (path, options) => {
    bodies.push(JSON.parse(options.body));
    return new Response('{}');
  });
  const socket = {};
  new Connection(() => {}, {make: () => socket});
  for (const uptime_ms of [7000, 8000]) socket.onmessage({data: JSON.stringify({op: 'time', time_ms: 1, uptime_ms})});
  socket.onmessage({data: '{"op":"topics","topics":[]}'});
  await post('api/set', {target: 'Active'});
  assert.deepEqual(bodies, [{target: 'Active', seen_uptime_ms: 8000}]);
});
