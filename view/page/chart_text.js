// Reads the state diagrams that get_behavior reports (Mermaid, as the robot writes it). Pure.

const plain = text => text.replace(/#(\d+);/g, (whole, code) => String.fromCodePoint(Number(code)));

const emptyChart = name => ({name, states: [], arrows: [], start: null, finals: new Set()});

// -> {name, states: [{id, name, safe, final, inside: chart or null}], arrows: [{from, to, text}], start},
// or null where it is no such diagram.
export function readChart(text, name = '') {
  const lines = (text ?? '').split('\n').map(line => line.trim());
  if (lines[0] !== 'stateDiagram-v2') return null;
  const all = new Map();
  const stack = [emptyChart(name)];
  for (const line of lines.slice(1)) {
    const chart = stack.at(-1);
    const state = /^state "(.*)" as (\w+)( \{)?$/.exec(line);
    const arrow = /^(\[\*\]|\w+) --> (\[\*\]|\w+)(?: : (.*))?$/.exec(line);
    const mark = /^class (\w+) (safe|present)$/.exec(line);
    if (state) {
      const made = {id: state[2], name: plain(state[1]), safe: false, final: false, inside: null};
      all.set(made.id, made);
      chart.states.push(made);
      if (state[3]) {
        made.inside = emptyChart(made.name);
        stack.push(made.inside);
      }
    } else if (line === '}' && stack.length > 1) {
      stack.pop();
    } else if (arrow && arrow[1] === '[*]') {
      chart.start = arrow[2];
    } else if (arrow && arrow[2] === '[*]') {
      if (all.has(arrow[1])) all.get(arrow[1]).final = true;
    } else if (arrow) {
      chart.arrows.push({from: arrow[1], to: arrow[2], text: plain(arrow[3] ?? '')});
    } else if (mark && mark[2] === 'safe' && all.has(mark[1])) {
      all.get(mark[1]).safe = true;
    }
  }
  return stack[0];
}

// The chart with one arrow from a state to another, for all that lead there: "a heart is seen (+2)".
export function joined(chart) {
  const arrows = new Map();
  for (const {from, to, text} of chart.arrows) {
    const key = `${from} ${to}`;
    const one = arrows.get(key) ?? {from, to, texts: []};
    if (text && !one.texts.includes(text)) one.texts.push(text);
    arrows.set(key, one);
  }
  return {...chart, arrows: [...arrows.values()].map(({from, to, texts}) => ({from, to,
    text: texts.length > 1 ? `${texts[0]} (+${texts.length - 1})` : texts[0] ?? ''}))};
}

// Of a chart with more than `most` states the present one (else the start), where it leads and what leads to
// it, at most `most` states; of another one all. `folded`: how many states are left out.
export function neighbourhood(chart, present, most) {
  const centre = (chart.states.find(s => s.name === present) ?? chart.states.find(s => s.id === chart.start)
    ?? chart.states[0])?.id;
  if (chart.states.length <= most) return {chart, folded: 0};
  const around = [...chart.arrows.filter(a => a.from === centre), ...chart.arrows.filter(a => a.to === centre)];
  const near = new Set([centre]);
  for (const id of around.map(a => (a.from === centre ? a.to : a.from))) if (near.size < most) near.add(id);
  const states = chart.states.filter(s => near.has(s.id));
  const arrows = around.filter((a, i) => near.has(a.from) && near.has(a.to) && around.indexOf(a) === i);
  return {chart: {...chart, states, arrows}, folded: chart.states.length - states.length};
}

// The chart and those inside of its states, each with the name of its present state ("" for none).
export function chartsWithPresent(chart, path) {
  const [present = '', ...rest] = (path ?? '').split('/');
  const list = [{chart, present}];
  for (const state of chart.states) {
    if (state.inside) list.push(...chartsWithPresent(state.inside,
      state.name === present ? rest.join('/') : ''));
  }
  return list;
}
