// The WebSocket to the server: it is opened again after it was closed, with a growing pause, and its
// messages go to `onMessage` as objects. The requests of the API are below.

const PAUSES_MS = [250, 500, 1000, 2000, 4000, 8000];

const REFUSED = 1008;  // the server wants a login

// The newest time of the server: each request brings it back, so that the server knows how old it is.
let seen_uptime_ms;

export class Connection {
  // `onMessage({op: 'link', link, retryAt})` reports the connection itself.
  constructor(onMessage, {make = () => new WebSocket(address(), 'musher.view.v1'), now = Date.now} = {}) {
    this.onMessage = onMessage;
    this.make = make;
    this.now = now;
    this.failures = 0;
    this.topics = [];
    this.timer = 0;
    this.open();
  }

  open() {
    clearTimeout(this.timer);
    this.timer = 0;
    this.onMessage({op: 'link', link: 'connecting'});
    const socket = this.make();
    this.socket = socket;
    socket.onopen = () => {
      this.onMessage({op: 'link', link: 'open'});
      if (this.topics.length) this.sendTopics();
    };
    socket.onmessage = event => {
      if (socket !== this.socket) return;
      this.failures = 0;
      let message = null;
      try {
        message = JSON.parse(event.data);
      } catch {
        return console.warn('the server sent a text that is no JSON');
      }
      seen_uptime_ms = message?.uptime_ms ?? seen_uptime_ms;
      if (message && typeof message.op === 'string') this.onMessage(message);
    };
    socket.onclose = event => {
      if (socket === this.socket) this.retry(event?.code === REFUSED);
    };
  }

  retry(refused) {
    const pause = PAUSES_MS[Math.min(this.failures++, PAUSES_MS.length - 1)];
    this.onMessage({op: 'link', link: 'closed', retryAt: this.now() + pause, refused});
    this.timer = setTimeout(() => this.open(), pause);
  }

  // Now instead of after the pause.
  retryNow() {
    if (this.timer) this.open();
  }

  // The server sends the latest sample of these topics too.
  watch(topics) {
    if (topics.join(' ') === this.topics.join(' ')) return;
    this.topics = topics;
    if (this.socket.readyState === 1) this.sendTopics();
  }

  sendTopics() {
    this.socket.send(JSON.stringify({op: 'watch', topics: this.topics}));
  }
}

function address() {
  const url = new URL('live', globalThis.location.href);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  url.hash = '';
  return url.href;
}

// An error of the API; `code` is Musher's, `status` HTTP's (0: no answer).
export class ApiError extends Error {
  constructor(status, code, message) {
    super(message);
    this.status = status;
    this.code = code;
  }
}

// Of all requests but an emergency stop. A browser has six connections: without an answer to six requests
// the stop would wait unsent, so it ends them.
let others = new AbortController();

async function request(path, options) {
  let response;
  try {
    response = await fetch(path, {credentials: 'same-origin', cache: 'no-store', ...options});
  } catch (error) {
    throw new ApiError(0, 0, /^(Timeout|Abort)Error$/.test(error.name) ? '' : error.message);
  }
  const text = await response.text();
  let value = null;
  try {
    value = text === '' ? {} : JSON.parse(text);
  } catch {
    throw new ApiError(response.status, 0, `HTTP ${response.status}`);
  }
  if (!response.ok || value?.error?.message) {
    throw new ApiError(response.status, value?.error?.code ?? 0,
      value?.error?.message ?? `HTTP ${response.status}`);
  }
  return value;
}

export function get(path, query = {}) {
  const parameters = new URLSearchParams(query).toString();
  return request(parameters ? `${path}?${parameters}` : path, {signal: others.signal});
}

// `within_ms`: of an emergency stop; without an answer by then it fails, and whether the robot has done it is
// not known.
export function post(path, body, {within_ms} = {}) {
  if (within_ms) {
    others.abort();
    others = new AbortController();
  }
  const signal = within_ms ? AbortSignal.timeout(within_ms) : others.signal;
  return request(path, {signal, method: 'POST', headers: {'Content-Type': 'application/json'},
    body: JSON.stringify({...body, seen_uptime_ms})});
}
