// Numbers over time: those of messages since the page was opened, and those of the history. Pure.
export const MOST_POINTS = 2000;
const MOST_NUMBERS = 200;  // of a message

// {a: {b: 1}, c: [2, 3], d: "x"} -> {"a.b": 1, "c.0": 2, "c.1": 3}: the numbers of a message by their path; true is 1.
export function numbersOf(message, path = '', found = {}) {
  for (const [key, value] of Object.entries(message ?? {})) {
    if (Object.keys(found).length >= MOST_NUMBERS) break;
    const here = path ? `${path}.${key}` : key;
    if (typeof value === 'number' || typeof value === 'boolean') found[here] = Number(value);
    else if (value !== null && typeof value === 'object') numbersOf(value, here, found);
  }
  return found;
}

// The points with one more; when there are too many, every second one is left out.
export function withPoint(points, ms, value) {
  const next = [...(points ?? []), {ms, value}];
  return next.length > MOST_POINTS ? next.filter((point, i) => i % 2 === (next.length - 1) % 2) : next;
}

// How long each switch of the robot took, at its end; in ms.
export function switchTimes(history) {
  const started = new Map();
  const points = [];
  for (const {event, switch_number: number, epoch, ms} of history) {
    if (event === 'switch_started') started.set(`${epoch} ${number}`, ms);
    const from = started.get(`${epoch} ${number}`);
    if (!/^switch_(done|done_degraded|undone)$/.test(event) || from === undefined) continue;
    points.push({ms, value: ms - from});
    started.delete(`${epoch} ${number}`);
  }
  return points;
}

// What is drawn of the points in [from, to]: those inside, and the last one before, which holds until the first of
// them; null where there is none.
export function shownOf(points, {from, to}) {
  const first = points.findIndex(point => point.ms > from);
  const end = points.findIndex(point => point.ms > to);
  const shown = points.slice(Math.max(0, first < 0 ? points.length - 1 : first - 1), end < 0 ? undefined : end);
  if (shown.length === 0) return null;
  const values = shown.map(point => point.value);
  return {points: shown, least: Math.min(...values), most: Math.max(...values), last: values.at(-1)};
}
