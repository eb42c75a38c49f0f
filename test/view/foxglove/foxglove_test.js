// Foxglove's own client library beside a robot of real processes.
import assert from 'node:assert/strict';
import {createRequire} from 'node:module';
import {after, before, test} from 'node:test';
import {parse} from '@foxglove/rosmsg';
import {MessageReader, MessageWriter} from '@foxglove/rosmsg2-serialization';
import WebSocket from 'ws';
import {startRobot} from '../robot.js';

const {FoxgloveClient} = createRequire(import.meta.url)('@foxglove/ws-protocol');
const DEADLINE_MS = 120000;

let robot = null;
let view = null;
before(async () => {
  robot = await startRobot();
  view = await robot.view();
});
after(() => robot?.close());

// A client that keeps what it receives; `until` waits for something in it.
class Client {
  constructor(query = '', {url} = view) {
    this.received = {channels: new Map(), services: new Map(), statuses: [], messages: [], answers: new Map(),
      failures: new Map()};
    this.waiting = [];
    const {received} = this;
    this.client = new FoxgloveClient({ws: new WebSocket(`${url.replace('http', 'ws')}${query}`,
      [FoxgloveClient.SUPPORTED_SUBPROTOCOL])});
    this.on('serverInfo', info => (received.info = info));
    this.on('status', status => received.statuses.push(status.message));
    this.on('advertise', channels => channels.forEach(channel => received.channels.set(channel.topic, channel)));
    this.on('unadvertise', ids => {
      for (const [topic, channel] of received.channels) {
        if (ids.includes(channel.id)) received.channels.delete(topic);
      }
    });
    this.on('advertiseServices',
      services => services.forEach(service => received.services.set(service.name, service)));
    this.on('message', message => received.messages.push(message));
    this.on('serviceCallResponse', answer => received.answers.set(answer.callId, answer));
    this.on('serviceCallFailure', failure => received.failures.set(failure.callId, failure.message));
    this.on('error', error => (received.error = error));
  }

  on(event, keep) {
    this.client.on(event, value => {
      keep(value);
      this.waiting = this.waiting.filter(look => !look());
    });
  }

  until(what, read) {
    return new Promise((done, fail) => {
      const timer = setTimeout(() => fail(new Error(`not within ${DEADLINE_MS} ms: ${what}; received ${
        JSON.stringify(this.received.statuses)} ${[...this.received.channels.keys()]} ${this.received.error}`)),
        DEADLINE_MS);
      const look = () => {
        const value = read(this.received);
        if (value === undefined || value === null || value === false) return false;
        clearTimeout(timer);
        done(value);
        return true;
      };
      if (!look()) this.waiting.push(look);
    });
  }

  channel(topic) {
    return this.until(topic, received => received.channels.get(topic));
  }

  async read(channel) {
    const subscription = this.client.subscribe(channel.id);
    const message = await this.until(`a message of ${channel.topic}`,
      received => received.messages.find(one => one.subscriptionId === subscription));
    return new MessageReader(parse(channel.schema, {ros2: true})).readMessage(message.data);
  }

  async call(name, request) {
    const service = await this.until(name, received => received.services.get(name));
    const callId = (this.calls = (this.calls ?? 0) + 1);
    this.client.sendServiceCallRequest({serviceId: service.id, callId, encoding: 'cdr',
      data: new Uint8Array(new MessageWriter(parse(service.request.schema, {ros2: true})).writeMessage(request))});
    const answer = await this.until(`the answer of ${name}`,
      received => received.answers.get(callId) ?? received.failures.get(callId));
    return typeof answer === 'string' ? {failure: answer}
      : new MessageReader(parse(service.response.schema, {ros2: true})).readMessage(answer.data);
  }

  close() {
    this.client.close();
  }
}

const topic = name => `/${robot.nameSpace}/musher/${name}`;

test('a client reads the status of the machine as it is on the wire', async () => {
  const client = new Client();
  const status = await client.read(await client.channel(topic('machine_status')));
  assert.equal(status.machine, 'dog');
  assert.equal(status.state, 'Active');
  assert.deepEqual(status.actuators.map(actuator => actuator.name), ['motion', 'audio']);
  assert.deepEqual(client.received.info.supportedEncodings, ['cdr']);
  client.close();
});

test('a second client gets what is latched, too', async () => {
  const clients = [new Client(), new Client()];
  for (const client of clients) {
    const status = await client.read(await client.channel(topic('machine_status')));
    assert.equal(status.machine, 'dog');
  }
  clients.forEach(client => client.close());
});

test('without the token a client calls what changes nothing, and nothing else', async () => {
  const client = new Client();
  const plan = await client.call(topic('get_plan'), {target: 'DeActive', actuator: ''});
  assert.equal(plan.allowed, true);
  assert.equal(plan.steps.length, 2);
  const refused = await client.call(topic('set_state'), {target: 'DeActive', actuator: ''});
  assert.match(refused.failure, /needs a login/);
  client.client.advertise({topic: '/chat', encoding: 'cdr', schemaName: 'std_msgs/msg/String'});
  await client.until('the refusal',
    received => received.statuses.find(text => /\/chat is not published: .*login/.test(text)));
  assert.equal((await robot.status()).state, 'Active');
  client.close();
});

test('with the token a client switches the machine', async () => {
  const client = new Client(`?token=${view.token}`);
  const answer = await client.call(topic('set_state'), {target: 'DeActive', actuator: ''});
  assert.equal(answer.outcome, 'done');
  assert.equal((await robot.status()).state, 'DeActive');
  assert.equal((await client.call(topic('set_state'), {target: 'Active', actuator: ''})).outcome, 'done');
  client.close();
});

test('with the token a client publishes, and others receive it', async () => {
  const client = new Client(`?token=${view.token}`);
  await client.until('the server', received => received.info);
  const id = client.client.advertise({topic: '/chat', encoding: 'cdr', schemaName: 'std_msgs/msg/String'});
  const bytes = new Uint8Array(new MessageWriter(parse('string data', {ros2: true})).writeMessage({data: 'hello'}));
  const other = new Client('', await robot.view());
  other.client.subscribe((await other.channel('/chat')).id);
  const timer = setInterval(() => client.client.sendMessage(id, bytes), 50);  // discovery takes a moment
  const message = await other.until('the message', received => received.messages[0]);
  clearInterval(timer);
  other.close();
  const received = new MessageReader(parse('string data', {ros2: true})).readMessage(message.data);
  assert.equal(received.data, 'hello');
  for (const [topicName, schemaName, why] of [['/chat2', 'my_msgs/msg/Own', /does not know the type/],
    [topic('machine_status'), 'musher_msgs/msg/MachineStatus', /the machine's own/],
    ['/no such name', 'std_msgs/msg/String', /letters, digits/]]) {
    client.client.advertise({topic: topicName, encoding: 'cdr', schemaName});
    await client.until(`the refusal of ${topicName}`,
      received => received.statuses.find(text => why.test(text)));
  }
  client.close();
});

test('a wrong token is none', async () => {
  const client = new Client('?token=00000000000000000000000000000000');
  const refused = await client.call(topic('set_state'), {target: 'DeActive', actuator: ''});
  assert.match(refused.failure, /needs a login/);
  client.close();
});

test('malformed messages are answered with a sentence, and the connection stays', async () => {
  const client = new Client();
  const channel = await client.channel(topic('machine_status'));
  const raw = new WebSocket(view.url.replace('http', 'ws'), ['foxglove.websocket.v1']);
  const said = [];
  raw.on('message', (data, binary) => {
    if (!binary) said.push(JSON.parse(data));
  });
  await new Promise(done => raw.once('open', done));
  for (const text of ['', '{', '[]', '{"op":1}', '{"op":"subscribe"}', '{"op":"subscribe","subscriptions":[{"id":-1}]}',
    `{"op":"subscribe","subscriptions":[{"id":1,"channelId":4294967295}]}`, '{"op":"fetchAsset"}']) raw.send(text);
  for (const bytes of [[], [1], [2, 0, 0], [9, 9, 9], [2, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255]]) {
    raw.send(Buffer.from(bytes));
  }
  raw.send(JSON.stringify({op: 'subscribe', subscriptions: [{id: 7, channelId: channel.id}]}));
  await new Promise(done => raw.on('message', (data, binary) => binary && done()));
  const statuses = said.filter(message => message.op === 'status');
  assert.equal(statuses.filter(status => status.level === 2).length, 11);
  assert.match(statuses[0].message, /malformed message: it is not a JSON object/);
  raw.close();
  client.close();
});
