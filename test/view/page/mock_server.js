// A server with the protocol of musher-view and a scripted robot behind it, for the tests of the page and
// for work on it:
//
//   node test/view/page/mock_server.js [PORT]    a robot that switches, has faults, is stopped, loses its controller
//
// The files of the page are read from view/page at each request.
import {readFile} from 'node:fs/promises';
import http from 'node:http';
import path from 'node:path';
import {fileURLToPath} from 'node:url';
import {WebSocketServer} from 'ws';
import {MockRobot} from './mock_robot.js';

const here = path.dirname(fileURLToPath(import.meta.url));
export const PAGE = path.resolve(here, '../../../view/page');
const TYPES = {'.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css',
  '.svg': 'image/svg+xml'};
const POLICY = "default-src 'self'; img-src 'self' data: blob:; connect-src 'self' ws: wss:";

export class MockServer {
  constructor({mayAct = true, mayStop = true, denied = false} = {}) {
    this.mayAct = mayAct;
    this.mayStop = mayStop;
    this.dark = false;        // the cameras give no picture
    this.silent = false;      // no message goes out: a server that hangs
    this.denied = denied;     // looking needs a login: 'refused' opens no WebSocket, 'closed' closes it with 1008
    this.older = [];          // entries of the history that are sent only on request
    this.requests = [];       // the acting ones, as {path, body}
    this.delay = async () => {};  // before an answer of the API
    this.waitLeg = async () => {};
    this.pages = new Set();
    this.robot = new MockRobot(message => this.broadcast(message));
    this.http = http.createServer((request, response) => {
      this.answer(request, response).catch(error => {
        response.writeHead(500).end(JSON.stringify({error: {code: 1, message: String(error)}}));
      });
    });
    this.sockets = new WebSocketServer({noServer: true, handleProtocols: () => 'musher.view.v1'});
    this.http.on('upgrade', (request, socket, head) => {
      if (this.refuse || this.denied === 'refused') return socket.destroy();
      this.sockets.handleUpgrade(request, socket, head, page => this.greet(page));
    });
    this.timer = setInterval(() => this.broadcast({op: 'time', time_ms: Date.now()}), 1000);
  }

  async listen(port = 0) {
    await new Promise(done => this.http.listen(port, '127.0.0.1', done));
    this.port = this.http.address().port;
    this.url = `http://127.0.0.1:${this.port}/`;
    return this;
  }

  broadcast(message) {
    if (this.silent) return;
    for (const page of this.pages) page.send(JSON.stringify(message));
  }

  greet(page) {
    if (this.denied) return page.close(1008, 'looking needs the login');
    this.pages.add(page);
    page.watched = [];
    const send = message => page.send(JSON.stringify(message));
    send({op: 'hello', version: '0.2.0', namespace: '', may_act: this.mayAct,
      may_stop: this.mayStop,
      who: this.mayAct ? 'alice at 127.0.0.1' : '', time_ms: Date.now()});
    for (const message of this.robot.greeting()) send(message);
    page.on('message', text => {
      const message = JSON.parse(text);
      if (message.op !== 'watch') return;
      page.watched = message.topics;
      for (const topic of message.topics) {
        const sample = this.robot.watched(topic);
        if (sample) send(sample);
      }
    });
    page.on('close', () => this.pages.delete(page));
  }

  // The latest sample of a watched topic goes to the pages that watch it.
  publishWatched(topic) {
    for (const page of this.pages) {
      if (page.watched.includes(topic)) page.send(JSON.stringify(this.robot.watched(topic)));
    }
  }

  drop() {
    for (const page of this.pages) page.terminate();
  }

  async answer(request, response) {
    const url = new URL(request.url, this.url);
    const json = (value, status = 200) => response.writeHead(status,
      {'Content-Type': 'application/json', 'Content-Security-Policy': POLICY})
      .end(JSON.stringify(value));
    if (request.method === 'POST') {
      const body = await bodyOf(request);
      await this.delay(url.pathname);
      return this.act(url.pathname, body, json);
    }
    if (url.pathname.startsWith('/api/')) {
      await this.delay(url.pathname);
      return this.look(url, json);
    }
    if (url.pathname === '/camera') return this.picture(url, response);
    return this.file(url.pathname === '/' ? '/index.html' : url.pathname, response);
  }

  async act(name, body, json) {
    if (name === '/api/plan') return json(this.robot.plan(body));
    if (name === '/api/login') {
      this.mayAct = body.pin === '482103';
      return this.mayAct ? json({}) : json({error: {code: 105, message: 'the PIN is wrong'}}, 403);
    }
    const may = this.mayAct || (this.mayStop && name === '/api/estop');
    if (!may) return json({error: {code: 403,
      message: 'acting needs the login: musher view --link'}}, 403);
    this.requests.push({path: name, body});
    if (name === '/api/set') return json(await this.robot.set(body, this.waitLeg, 'alice at 127.0.0.1'));
    if (name === '/api/estop') this.robot.engage('alice at 127.0.0.1', body.reason);
    else if (name === '/api/release') this.robot.release('alice at 127.0.0.1');
    else if (name === '/api/restart') this.robot.recover(body.actuator);
    else if (name === '/api/logout') this.mayAct = false;
    else if (name === '/api/skill' && body.parameters.name === 'full') return json({error: {code: 1,
      message: 'the disk is full; `musher status` shows how full'}}, 409);
    else if (name === '/api/pause_skill' && body.pause === this.robot.skillPaused) return json({error: {code: 106,
      message: body.pause ? 'goto is paused already' : 'goto is not paused'}}, 409);
    else if (name === '/api/pause_skill') this.robot.skillPaused = body.pause;
    else if (name === '/api/skill' || name === '/api/cancel_skill') return json({goal_id: '01'});
    else return json({error: {code: 404, message: `no such request: ${name}`}}, 404);
    return json({code: 0, reason: ''});
  }

  look(url, json) {
    const name = url.searchParams.get('name');
    if (this.denied) return json({error: {code: 401, message: 'looking needs the login'}}, 401);
    if (url.pathname === '/api/history') return json({entries: [...this.older, ...this.robot.history]});
    if (url.pathname === '/api/behavior' && name === 'wedding') return json(this.robot.behaviorReport());
    if (url.pathname === '/api/tree' && name === 'gardener') return json(this.robot.tree());
    if (url.pathname === '/api/log') {
      const name = url.searchParams.get('actuator');
      const lines = Array.from({length: 300}, (_, i) => `2026-06-01 12:0${Math.floor(i / 60)}:${String(i % 60).padStart(2, '0')}.000 ${name}: ${
        i % 37 === 5 ? 'warning: the gyroscope drifts' : 'the loop took 2.1 ms'}, line ${i + 1}\n`).join('');
      const requested = Number(url.searchParams.get('from') ?? 0);
      const from = Math.min(lines.length, Math.max(0, requested < 0 ? lines.length + requested : requested));
      return json({from, to: lines.length, size: lines.length, text: lines.slice(from)});
    }
    return json({error: {code: 404, message: `nothing here: ${url.pathname}`}}, 404);
  }

  async picture(url, response) {
    if (this.dark) return response.writeHead(204).end();
    const file = path.resolve(here, '../../../docs/images/robot-saw.jpg');
    response.writeHead(200, {'Content-Type': 'image/jpeg',
      'X-Stamp-Ms': String(Date.now())}).end(await readFile(file));
  }

  async file(name, response) {
    const file = path.join(PAGE, path.normalize(name));
    try {
      const text = await readFile(file);
      response.writeHead(200, {'Content-Type': TYPES[path.extname(file)] ?? 'text/plain',
        'Content-Security-Policy': POLICY}).end(text);
    } catch {
      response.writeHead(404).end();
    }
  }

  async close() {
    clearInterval(this.timer);
    this.drop();
    this.sockets.close();
    this.http.closeAllConnections();
    await new Promise(done => this.http.close(done));
  }
}

async function bodyOf(request) {
  let text = '';
  for await (const part of request) text += part;
  return JSON.parse(text || '{}');
}

// A switch, a fault, an emergency stop, the controller gone and back; and again.
function play(server) {
  const {robot} = server;
  const pause = ms => () => new Promise(done => setTimeout(done, ms));
  server.waitLeg = pause(700);
  const steps = [() => robot.set({target: 'LowPower', actuator: ''}, server.waitLeg, 'the script'),
    () => robot.set({target: 'Active', actuator: ''}, server.waitLeg, 'the script'),
    () => robot.fault('audio'), () => robot.recover('audio'),
      () => robot.engage('the script', 'a person is near'), () => robot.release('the script'),
    () => robot.controllerEnds(), () => robot.controllerReturns()];
  let next = 0;
  const timer = setInterval(() => steps[next++ % steps.length](), 6000);
  server.http.on('close', () => clearInterval(timer));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const server = await new MockServer().listen(Number(process.argv[2] ?? 8765));
  play(server);
  console.log(`a scripted robot: ${server.url}`);
}
