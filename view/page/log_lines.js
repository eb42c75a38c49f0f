// Lines of logs: their times and levels, and several logs as one by time. Pure.

export const LEVELS = ['debug', 'info', 'warning', 'error'];
const TIME = /^(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d(?:\.\d+)?)\S* /;
const OWN = /^(?:[\w./@-]+: )?(debug|warning|error): /;        // musher::WriteLog
const ROS = /^(?:\[[^\]]*\] )*\[(DEBUG|INFO|WARN|ERROR|FATAL)\]/;  // rcutils
const ROS_LEVELS = {DEBUG: 'debug', INFO: 'info', WARN: 'warning', ERROR: 'error', FATAL: 'error'};

// A line without a time has that of the line before it; one that is indented (a backtrace) also its level.
export function readLines(text, name) {
  let time = '';
  let level = 'info';
  return text.trimEnd().split('\n').filter((line, i, all) => line !== '' || all.length > 1).map(line => {
    const found = TIME.exec(line);
    if (found) time = `${found[1]} ${found[2]}`;
    const rest = found ? line.slice(found[0].length) : line;
    const ros = ROS.exec(rest)?.[1];
    if (!/^\s/.test(line)) level = ROS_LEVELS[ros] ?? OWN.exec(rest)?.[1] ?? 'info';
    return {name, time, level, text: line};
  });
}

// By time; lines of the same time stay in their order.
export function merged(logs) {
  return logs.length === 1 ? logs[0] : logs.flat().sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : 0));
}

// The lines of a level and above that contain `find`; of several logs each with the name of its log.
export function chosenLines(lines, {level = 'debug', find = '', several = false}) {
  const least = LEVELS.indexOf(level);
  const low = find.toLowerCase();
  return lines.filter(line => LEVELS.indexOf(line.level) >= least && line.text.toLowerCase().includes(low))
    .map(line => (several ? `${line.name} | ${line.text}` : line.text));
}
