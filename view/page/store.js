// What the page knows: messages of the server in, values for the views out. Pure: time is an argument,
// and no message changes a state that was handed out.
import {nsToMs, toNumber} from './format.js';
import {numbersOf, withPoint} from './plots_model.js';

export const OLD_AFTER_MS = 3000;
const MOST_HISTORY = 5000;
const MOST_OBSERVED = 500;

export function initialState() {
  return {
    link: 'connecting',  // 'connecting', 'open' or 'closed'
    lastReceived: 0,     // the page's clock, when the last message was received
    retryAt: 0,
    offset: 0,           // of the robot's clock: add it to the page's
    hello: null,
    latest: {},          // by topic: {type, received_ms, message}
    gone: {},            // by topic: true
    topics: [],
    history: [],         // oldest first, each with `ms`
    processes: {},       // by actuator
    offers: {},          // by actuator: its SkillOffers
    feedback: {},        // by "actuator skill": the last SkillFeedback
    numbers: {},         // by the id of a plot, "battery", "cpu audio", "/imu linear.x": [{ms, value}]
    plots: [],           // ids of the plots of topics, whose numbers are kept
    observed: {},        // by actuator ('': the machine): [{ms, state}], since the page was opened
  };
}

const entryKey = entry => `${entry.epoch}/${entry.id}/${entry.wall_ns}`;

function withTime(entry) {
  return {...entry, ms: nsToMs(entry.wall_ns), id: toNumber(entry.id), cause: toNumber(entry.cause),
    epoch: toNumber(entry.epoch), event: entry.event ?? ''};
}

function addHistory(before, message) {
  const known = message.reset ? [] : before;
  const seen = new Set(known.slice(-1000).map(entryKey));
  const added = (message.entries ?? []).map(withTime).filter(entry => !seen.has(entryKey(entry)));
  return added.length === 0 && !message.reset ? before : [...known, ...added].slice(-MOST_HISTORY);
}

function addOlder(history, entries) {
  const first = history[0]?.ms ?? Infinity;
  const known = new Set(history.slice(0, 100).map(entryKey));
  const older = entries.map(withTime).filter(entry => entry.ms <= first && !known.has(entryKey(entry)));
  return older.length === 0 ? history : [...older, ...history].slice(-MOST_HISTORY);
}

// What an actuator is, as one word for the timeline.
export function shownState(actuator) {
  if (actuator.presence === 'lost' || actuator.presence === 'absent') return actuator.presence;
  if (actuator.presence === 'starting') return 'starting';
  return actuator.state;
}

function observe(observed, status, ms) {
  let result = observed;
  const add = (name, state) => {
    const past = result[name] ?? [];
    if (past.at(-1)?.state !== state) result = {...result,
      [name]: [...past, {ms, state}].slice(-MOST_OBSERVED)};
  };
  add('', status.state);
  for (const actuator of status.actuators ?? []) add(actuator.name, shownState(actuator));
  return result;
}

function keepNumbers(numbers, values, ms) {
  const next = {...numbers};
  for (const [id, value] of Object.entries(values)) next[id] = withPoint(numbers[id], ms, value);
  return next;
}

// The numbers of a message that are plotted, by the ids of their plots.
function plottedOf(state, topic, message) {
  const ids = state.plots.filter(id => id.startsWith(`${topic} `));
  const found = ids.length ? numbersOf(message) : {};
  return Object.fromEntries(ids.map(id => [id, found[id.slice(topic.length + 1)]])
    .filter(([, value]) => value !== undefined));
}

function usageOf(processes) {
  return Object.fromEntries(processes.flatMap(p => [[`cpu ${p.name}`, p.cpu_percent],
    [`memory ${p.name}`, p.rss_bytes]]));
}

const isStatus = topic => topic.endsWith('/musher/machine_status');

function addLatest(state, message) {
  const {topic, type, received_ms} = message;
  const gone = {...state.gone};
  delete gone[topic];
  const next = {...state, gone, latest: {...state.latest,
    [topic]: {type, received_ms, message: message.message}}};
  const value = message.message;
  if (type === 'musher_msgs/msg/SkillOffers') next.offers = {...state.offers, [value.actuator]: value};
  if (type === 'musher_msgs/msg/SkillFeedback') next.feedback = {...state.feedback,
    [`${value.actuator} ${value.skill}`]: value};
  next.numbers = keepNumbers(state.numbers, plottedOf(state, topic, value), received_ms);
  if (isStatus(topic)) {
    next.observed = observe(state.observed, value, received_ms);
    const {active, battery} = value.policy ?? {};
    if (active && battery >= 0) next.numbers = keepNumbers(next.numbers, {battery}, received_ms);
  }
  return next;
}

// The state after one message of the server, or one of the connection ("link").
export function apply(before, message, now) {
  if (message.op === 'link') return {...before, link: message.link, retryAt: message.retryAt ?? 0};
  const state = {...before, lastReceived: now};
  switch (message.op) {
    case 'hello':
      return {...state, hello: message, offset: (message.time_ms ?? now) - now, latest: {}, gone: {}};
    case 'latest':
      return addLatest(state, message);
    case 'gone':
      return {...state, gone: {...state.gone, [message.topic]: true}};
    case 'topics':
      return {...state, topics: message.topics ?? []};
    case 'history':
      return {...state, history: addHistory(state.history, message)};
    case 'older':  // of the page itself: what it has fetched from before the first entry
      return {...state, history: addOlder(state.history, message.entries ?? [])};
    case 'processes':
      return {...state, processes: Object.fromEntries((message.actuators ?? []).map(a => [a.name, a])),
        numbers: keepNumbers(state.numbers, usageOf(message.actuators ?? []), robotNow(state, now))};
    case 'plot':  // of the page itself
      return {...before, plots: message.ids.filter(id => id.startsWith('/'))};
    case 'time':
      return {...state, offset: (message.time_ms ?? now) - now};
    default:
      return state;  // of a newer server
  }
}

function find(state, ending) {
  const topic = Object.keys(state.latest).find(name => name.endsWith(ending));
  return topic === undefined ? null : {topic, ...state.latest[topic]};
}

export const mayAct = state => state.hello?.may_act === true;
// Also of a page that may not look, whose server does not say so.
export const mayStop = state => state.hello?.may_stop ?? true;
export const robotNow = (state, now) => now + state.offset;
export const statusOf = state => find(state, '/musher/machine_status')?.message ?? null;
// For a request that acts: the server may follow another machine meanwhile.
export function shownMachine(state) {
  const {machine = '', machine_id = ''} = statusOf(state) ?? {};
  return {machine, machine_id};
}
export const capabilitiesOf = state => find(state, '/musher/capabilities')?.message.capabilities ?? [];

// "live"; "old": the server is silent or unreachable; "gone": the controller has ended; "waiting":
// connected, but no controller has been seen.
export function freshness(state, now) {
  if (state.link !== 'open' || now - state.lastReceived > OLD_AFTER_MS) {
    return state.hello === null && state.link === 'connecting' ? 'connecting' : 'old';
  }
  const status = find(state, '/musher/machine_status');
  if (status === null) return state.hello === null ? 'connecting' : 'waiting';
  return state.gone[status.topic] ? 'gone' : 'live';
}

// When the machine came to its present state, by the history; 0: not known.
export function stateSince(state) {
  const last = state.history.findLast(entry => entry.state);
  return last && last.state === statusOf(state)?.state ? last.ms : 0;
}

function adviceFor(actuator) {
  if (actuator.restarting) return 'wait_restart';
  if (/held by an emergency stop/.test(actuator.message)) return 'set_again';
  if (/self-check/.test(actuator.message) && actuator.presence === 'present') return 'self_check';
  if (actuator.health === 'hung') return 'restart_hung';
  if (actuator.health === 'starved') return 'reduce_load';
  if (actuator.health === 'partitioned') return 'check_network';
  if (actuator.presence !== 'present' || actuator.health === 'crashed') return 'log_then_restart';
  return 'see_log';
}

function problemOf(actuator) {
  const lost = actuator.presence === 'lost' || (actuator.presence === 'absent' && actuator.degraded);
  if (!actuator.degraded && actuator.health === 'well' && !lost) return null;
  const kind = ['hung', 'crashed', 'starved', 'partitioned'].includes(actuator.health) ? actuator.health
    : lost ? 'lost' : 'degraded';
  return {id: `actuator ${actuator.name}`, level: actuator.critical ? 'bad' : 'warn', what: `problem.${kind}`,
    name: actuator.name, why: actuator.message, code: actuator.code, advice: adviceFor(actuator)};
}

// What is wrong, the worst first: {id, level: "bad"|"warn"|"info", what: key of a text, name, why, code,
// advice: key of a text}.
export function problems(state) {
  const status = statusOf(state);
  if (!status) return [];
  const list = [];
  const add = (id, level, why, advice, name = '', code = 0) =>
    list.push({id, level, what: `problem.${id}`, name, why, code, advice});
  if (status.emergency_stop) add('stop', 'bad', status.emergency_stop_reason, 'release',
    status.emergency_stop_by);
  if (status.not_stopped?.length) add('not_stopped', 'bad', status.not_stopped.join('; '), 'cut_power');
  if (status.phase === 'failed') add('start', 'bad', '', 'self_check');
  for (const actuator of status.actuators ?? []) {
    const problem = problemOf(actuator);
    if (problem) list.push(problem);
  }
  const policy = status.policy ?? {};
  if (policy.power) add('power', 'warn', '', 'wait', policy.power);
  if (policy.ceiling) add('ceiling', 'warn', policy.ceiling_reason, 'charge', policy.ceiling);
  if (policy.battery_silent) add('battery_silent', 'warn', '', 'check_battery');
  if ((status.not_on_disk ?? []).length) add('disk', 'warn', status.not_on_disk.join('; '), 'check_disk');
  if (status.violated_rules?.length) add('rule', 'warn', status.violated_rules.join('; '), 'check_rule');
  const held = (status.held_by_stop ?? []).filter(() => !status.emergency_stop);
  if (held.length) add('held', 'info', '', 'set_again', held.join(', '));
  const order = {bad: 0, warn: 1, info: 2};
  return list.sort((a, b) => order[a.level] - order[b.level]);
}

const GOOD = new Set(['switch_done', 'machine_usable', 'machine_adopted', 'actuator_recovered',
  'emergency_stop_released']);

// "bad", "warn", "ok" or "": how an event is marked.
export function levelOf(entry) {
  if (entry.event === 'emergency_stop_engaged') return 'bad';
  if (entry.code !== 0) return /degraded|refused|suspended|superseded|skipped/.test(entry.event) ? 'warn'
    : 'bad';
  if (/^(actuator_starved|battery_silent|battery_switch_down|restart_|save_failed|fallback_)/.test(entry.event)) return 'warn';
  return GOOD.has(entry.event) ? 'ok' : '';
}

export const FAULTS_STAY_MS = 10 * 60_000;

// What a person acknowledges who sees this state: {machine_id: {epoch, id, ms}}.
export function acknowledgement({history, ...state}) {
  const {epoch = 0, id = 0} = history.findLast(entry => entry.id) ?? {};
  return {[shownMachine(state).machine_id]: {epoch, id, ms: history.at(-1)?.ms}};
}

// The faults of the last minutes that no person has acknowledged, the newest first: a robot that is well again hides
// nothing. Compared by place: clocks go back, epochs begin again, and some entries have no id.
export function recentFaults(state, now, acknowledged) {
  const {epoch, id, ms} = acknowledged[shownMachine(state).machine_id] ?? {};
  const seen = state.history.findLastIndex(e => (e.id ? e.epoch === epoch && e.id <= id && e.ms <= ms : e.ms === ms));
  const since = robotNow(state, now) - FAULTS_STAY_MS;
  return state.history.slice(seen + 1).filter(e => e.ms > since && levelOf(e) === 'bad').reverse();
}

const OFFERED = ['Active', 'Protected', 'DeActive', 'LowPower', 'SelfCheck', 'OTA', 'TearDown'];

// States that a person may choose: the built-in ones, and those of the config that were seen.
export function offeredStates(state) {
  const status = statusOf(state);
  const seen = new Set();
  for (const capability of capabilitiesOf(state)) for (const name of capability.states ?? []) seen.add(name);
  for (const entry of state.history) if (entry.state) seen.add(entry.state);
  for (const actuator of status?.actuators ?? []) if (actuator.state) seen.add(actuator.state);
  for (const name of [...OFFERED, 'Uninitialized', 'SetUp', 'Error']) seen.delete(name);
  return [...OFFERED.slice(0, 4), ...[...seen].sort(), ...OFFERED.slice(4)];
}

// How an actuator is doing in a switch to `to`: "done", "running", "waiting" or "trouble".
export function legState(actuator, to) {
  if (!actuator || actuator.presence === 'lost' || actuator.degraded) return 'trouble';
  if (actuator.state === to && !actuator.target) return 'done';
  return actuator.target ? 'running' : 'waiting';
}
