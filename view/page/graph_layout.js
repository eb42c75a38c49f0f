// A layered layout for state machines: layers from top to bottom, every arrow with room for its text. Pure.
// Arrows that lead back are laid out as if they led forward, so each pair of states gets separate lines.

const NODE_HEIGHT = 36;
const ROW = 42;        // from a layer of states to the layer of texts below it
const GAP = 22;
const LINE_WIDTH = 14; // of an arrow without a text

export const textWidth = (text, size) => [...text].reduce((sum,
  c) => sum + (c.charCodeAt(0) > 0x2e80 ? 1.05 : 0.6), 0) * size;

// Finds the arrows that close a cycle, by a search in depth from the start.
function backArrows(states, arrows, start) {
  const out = new Map(states.map(s => [s.id, []]));
  for (const arrow of arrows) out.get(arrow.from)?.push(arrow);
  const colour = new Map();
  const back = new Set();
  const visit = id => {
    colour.set(id, 1);
    for (const arrow of out.get(id)) {
      if (colour.get(arrow.to) === 1) back.add(arrow);
      else if (!colour.has(arrow.to)) visit(arrow.to);
    }
    colour.set(id, 2);
  };
  for (const id of [start, ...states.map(s => s.id)]) if (out.has(id) && !colour.has(id)) visit(id);
  return back;
}

function ranksOf(states, edges) {
  const rank = new Map(states.map(s => [s.id, 0]));
  for (let round = 0; round < states.length; ++round) {
    let changed = false;
    for (const {a, b} of edges) {
      if (rank.get(b) < rank.get(a) + 1) {
        rank.set(b, rank.get(a) + 1);
        changed = true;
      }
    }
    if (!changed) break;
  }
  return rank;
}

// Puts a place on each layer that an arrow crosses; the one in its middle has the width of its text.
function addPlaces(layers, edges) {
  for (const edge of edges) {
    const first = edge.from.layer + 1;
    const count = edge.to.layer - first;
    const middle = first + 2 * Math.floor(count / 4);  // layers of texts are the odd ones
    edge.places = [];
    for (let layer = first; layer < edge.to.layer; ++layer) {
      const text = layer === middle ? edge.arrow.text : '';
      const place = {width: text ? textWidth(text, 12) + 12 : LINE_WIDTH, layer, edge, text, next: [],
        before: []};
      edge.places.push(place);
      layers[layer].push(place);
    }
    const line = [edge.from, ...edge.places, edge.to];
    for (let i = 0; i + 1 < line.length; ++i) {
      line[i].next.push(line[i + 1]);
      line[i + 1].before.push(line[i]);
    }
  }
}

const mean = list => list.reduce((sum, v) => sum + v, 0) / list.length;

function order(layers) {
  const number = layer => layer.forEach((place, i) => (place.order = i));
  layers.forEach(number);
  for (let sweep = 0; sweep < 8; ++sweep) {
    const down = sweep % 2 === 0;
    for (const layer of down ? layers : [...layers].reverse()) {
      for (const place of layer) {
        const near = down ? place.before : place.next;
        place.wanted = near.length ? mean(near.map(n => n.order)) : place.order;
      }
      layer.sort((a, b) => a.wanted - b.wanted);
      number(layer);
    }
  }
}

// Moves the places of a layer towards where they are wanted, in order and without overlaps: midway between
// the placement that starts at the left and the one that starts at the right.
function settle(layer, wanted) {
  const want = layer.map(wanted);
  const apart = (i, j) => (layer[i].width + layer[j].width) / 2 + GAP;
  const left = [];
  const right = [];
  for (let i = 0; i < layer.length; ++i) left[i] = i === 0 ? want[i]
    : Math.max(want[i], left[i - 1] + apart(i - 1, i));
  for (let i = layer.length - 1; i >= 0; --i) {
    right[i] = i + 1 === layer.length ? want[i] : Math.min(want[i], right[i + 1] - apart(i, i + 1));
  }
  layer.forEach((place, i) => (place.x = (left[i] + right[i]) / 2));
}

function coordinates(layers) {
  for (const layer of layers) settle(layer, place => place.order * 80);
  for (let sweep = 0; sweep < 10; ++sweep) {
    const down = sweep % 2 === 0;
    for (const layer of down ? layers : [...layers].reverse()) {
      settle(layer, place => {
        const near = sweep > 7 ? [...place.before, ...place.next] : down ? place.before : place.next;
        return near.length ? mean(near.map(n => n.x)) : place.x;
      });
    }
  }
}

// {states: [{id, name}], arrows: [{from, to, text}], start} ->
// {width, height, states: [{..., x, y, width, height}], arrows: [{..., points: [[x, y]], label: {x, y, text}}]}
export function layOut({states, arrows, start}) {
  if (states.length === 0) return {width: 0, height: 0, states: [], arrows: []};
  const known = new Set(states.map(s => s.id));
  const drawn = arrows.filter(a => known.has(a.from) && known.has(a.to) && a.from !== a.to);
  const back = backArrows(states, drawn, start);
  const edges = drawn.map(arrow => (back.has(arrow) ? {a: arrow.to, b: arrow.from, arrow}
    : {a: arrow.from, b: arrow.to, arrow}));
  const rank = ranksOf(states, edges);
  const nodes = new Map(states.map(state => [state.id, {state,
    width: Math.max(64, textWidth(state.name, 14) + 30),
    layer: rank.get(state.id) * 2, next: [], before: []}]));
  const layers = Array.from({length: Math.max(0, ...[...nodes.values()].map(n => n.layer)) + 1}, () => []);
  for (const node of nodes.values()) layers[node.layer].push(node);
  for (const edge of edges) Object.assign(edge, {from: nodes.get(edge.a), to: nodes.get(edge.b)});
  addPlaces(layers, edges);
  order(layers);
  coordinates(layers);
  const all = layers.flat();
  const left = Math.min(...all.map(p => p.x - p.width / 2)) - 14;
  const right = Math.max(...all.map(p => p.x + p.width / 2)) + 4;
  const y = layer => 26 + layer * ROW;
  return {
    width: right - left,
    height: y(layers.length - 1) + 26,
    states: [...nodes.values()].map(n => ({...n.state, x: n.x - left, y: y(n.layer), width: n.width,
      height: NODE_HEIGHT})),
    arrows: edges.map(edge => arrowOf(edge, left, y, back)),
  };
}

// Where a line leaves a state: spread over its side, in the order of where the lines go.
function port(node, side, other) {
  const list = [...node[side]].sort((a, b) => a.x - b.x);
  const share = (list.indexOf(other) + 1) / (list.length + 1) - 0.5;
  return node.x + share * (node.width - 16);
}

function arrowOf(edge, left, y, back) {
  const {arrow, from, to, places} = edge;
  const points = [[port(from, 'next', places[0] ?? to) - left, y(from.layer) + NODE_HEIGHT / 2],
    ...places.map(p => [p.x - left, y(p.layer)]),
    [port(to, 'before', places.at(-1) ?? from) - left, y(to.layer) - NODE_HEIGHT / 2]];
  const place = places.find(p => p.text);
  if (back.has(arrow)) points.reverse();
  return {...arrow, back: back.has(arrow), points, label: place
    ? {x: place.x - left, y: y(place.layer), text: place.text} : null};
}

// A smooth line through the points, vertical at each of them.
export function pathOf(points) {
  let path = `M${points[0][0].toFixed(1)} ${points[0][1].toFixed(1)}`;
  for (let i = 1; i < points.length; ++i) {
    const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
    const middle = ((y0 + y1) / 2).toFixed(1);
    path += `C${x0.toFixed(1)} ${middle} ${x1.toFixed(1)} ${middle} ${x1.toFixed(1)} ${y1.toFixed(1)}`;
  }
  return path;
}
