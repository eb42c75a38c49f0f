// Numbers and times as people read them. Pure; times are in milliseconds since 1970.

// 64-bit integers beyond 2^53 are sent as decimal text.
export function toNumber(value) {
  return typeof value === 'string' ? Number(value) : (value ?? 0);
}

export function nsToMs(value) {
  if (typeof value === 'string' && value.length > 6) return Number(value.slice(0,
    -6)) + Number('0.' + value.slice(-6));
  return toNumber(value) / 1e6;
}

const two = n => String(n).padStart(2, '0');

export function clock(ms) {
  const d = new Date(ms);
  return `${two(d.getHours())}:${two(d.getMinutes())}:${two(d.getSeconds())}`;
}

export function clockFine(ms) {
  return `${clock(ms)}.${String(Math.floor(((ms % 1000) + 1000) % 1000)).padStart(3, '0')}`;
}

export function day(ms) {
  const d = new Date(ms);
  return `${d.getFullYear()}-${two(d.getMonth() + 1)}-${two(d.getDate())}`;
}

// The time alone when it is of today, else with its day.
export function when(ms, now) {
  return day(ms) === day(now) ? clock(ms) : `${day(ms).slice(5)} ${clock(ms)}`;
}

// A length of time: "850 ms", "3.2 s", "4 min 05 s", "2 h 10 min", "3 d 4 h".
export function duration(ms) {
  if (ms < 1000) return `${Math.max(0, Math.round(ms))} ms`;
  if (ms < 10000) return `${(Math.floor(ms / 100) / 10).toFixed(1)} s`;
  const s = Math.floor(ms / 1000);
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${two(s % 60)} s`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ${two(Math.floor(s / 60) % 60)} min`;
  return `${Math.floor(s / 86400)} d ${Math.floor(s / 3600) % 24} h`;
}

export function bytes(count) {
  if (!(count >= 0)) return '–';
  if (count < 1000) return `${count} B`;
  const units = ['kB', 'MB', 'GB', 'TB'];
  let value = count / 1000;
  let unit = 0;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    ++unit;
  }
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

export function percent(value) {
  if (!(value >= 0)) return '–';
  return `${value < 10 ? (Math.round(value * 10) / 10).toFixed(1) : Math.round(value)} %`;
}
