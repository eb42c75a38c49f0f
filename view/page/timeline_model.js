// What the timeline draws, from the history and from what was observed since the page was opened. Pure.
import {levelOf} from './store.js';

// What an event says about the state of its actuator; null: nothing. The sentences are those of the
// history: a state that only stands in a sentence is read from it.
export function stateOfEvent(entry) {
  switch (entry.event) {
    case 'command_done':
      return /: (\S+) done after /.exec(entry.message)?.[1] ?? null;
    case 'actuator_present':
      return / is present in (\S+)/.exec(entry.message)?.[1] ?? null;
    case 'actuator_drifted':
      return / has switched to (\S+) by itself/.exec(entry.message)?.[1] ?? null;
    case 'process_started':
      return 'starting';
    case 'process_exited':
    case 'actuator_crashed':
    case 'actuator_killed':
      return 'lost';
    default:
      return null;
  }
}

function merge(changes, observed) {
  const all = [...changes, ...(observed ?? [])].sort((a, b) => a.ms - b.ms);
  return all.filter((change, i) => i === 0 || all[i - 1].state !== change.state);
}

// [{ms, state}] -> [{from, to, state}]; the last one lasts until `now`.
export function spansOf(changes, now) {
  return changes.map((change, i) => ({from: change.ms, to: changes[i + 1]?.ms ?? Math.max(now, change.ms),
    state: change.state}));
}

// Lanes of the robot ('') and of its actuators: {name, changes, marks: [{ms, level, entry}]}; and `stops`,
// the times of emergency stops as {from, to}, where `to` is null while one is engaged.
export function lanesOf(history, observed, names) {
  const lanes = new Map(['', ...names].map(name => [name, {name, changes: [], marks: []}]));
  const stops = [];
  for (const entry of history) {
    const level = levelOf(entry);
    const stop = entry.event === 'emergency_stop_engaged';
    if (stop && stops.at(-1)?.to !== null) stops.push({from: entry.ms, to: null});
    if (entry.event === 'emergency_stop_released' && stops.length) stops.at(-1).to = entry.ms;
    const lane = lanes.get(entry.actuator);
    if (entry.state) lanes.get('').changes.push({ms: entry.ms, state: entry.state});
    if (!lane) continue;
    if (lane.name) {
      const state = stateOfEvent(entry);
      if (state) lane.changes.push({ms: entry.ms, state});
    }
    if (level === 'bad' || level === 'warn') lane.marks.push({ms: entry.ms, level, entry, stop});
  }
  for (const lane of lanes.values()) lane.changes = merge(lane.changes, observed[lane.name]);
  return {lanes: [...lanes.values()], stops};
}

const STEPS_MS = [100, 200, 500, 1e3, 2e3, 5e3, 10e3, 15e3, 30e3, 60e3, 120e3, 300e3, 600e3, 900e3, 1800e3,
  3600e3, 7200e3,
  21600e3, 43200e3, 86400e3, 172800e3, 604800e3];

// Times of the axis between `from` and `to`, at most `most` of them, on whole steps of the local day.
export function ticks(from, to, most) {
  const step = STEPS_MS.find(s => (to - from) / s <= most) ?? STEPS_MS.at(-1);
  const shift = new Date(from).getTimezoneOffset() * 60000;
  const list = [];
  for (let at = Math.ceil((from - shift) / step) * step + shift; at <= to; at += step) list.push(at);
  return {step, list};
}

export const LEAST_MS = 500;
export const MOST_MS = 40 * 86400e3;

// The window {from, to} made `factor` times as long, around the time `at`.
export function zoomed(window, factor, at) {
  const length = window.to - window.from;
  const next = Math.min(MOST_MS, Math.max(LEAST_MS, length * factor));
  const share = (at - window.from) / length;
  return {from: at - share * next, to: at + (1 - share) * next};
}

export function panned(window, share) {
  const by = (window.to - window.from) * share;
  return {from: window.from + by, to: window.to + by};
}
