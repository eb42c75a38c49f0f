// The library of MCAP finds the schemas of a recording, and that of Foxglove reads its messages by nothing else.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import path from 'node:path';
import {after, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {parse} from '@foxglove/rosmsg';
import {MessageReader} from '@foxglove/rosmsg2-serialization';
import {McapIndexedReader} from '@mcap/core';

const here = path.dirname(fileURLToPath(import.meta.url));
const program = path.join(process.env.MUSHER_BIN ?? path.resolve(here, '../../../build/dev/bin'),
  'view_record_schema_sample');
const folder = mkdtempSync(path.join(tmpdir(), 'musher-test-'));
after(() => rmSync(folder, {recursive: true}));

async function readRecording() {
  const file = path.join(folder, 'a.mcap');
  execFileSync(program, [file]);
  const bytes = readFileSync(file);
  const reader = await McapIndexedReader.Initialize({readable: {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  }});
  const found = {};
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const definition = parse(new TextDecoder().decode(schema.data), {ros2: true});
    found[channel.topic] = {type: schema.name, encodings: [schema.encoding, channel.messageEncoding],
      logTime: message.logTime, message: new MessageReader(definition).readMessage(message.data)};
  }
  return found;
}

test('each message of a recording is read by the schema that the file has', async () => {
  const found = await readRecording();
  assert.deepEqual(Object.keys(found), ['/chat', '/musher/machine_status', '/joint_states']);
  for (const {encodings} of Object.values(found)) assert.deepEqual(encodings, ['ros2msg', 'cdr']);
  assert.equal(found['/chat'].type, 'std_msgs/msg/String');
  assert.equal(found['/chat'].message.data, 'hello');
  assert.equal(found['/chat'].logTime, 1772366405000000001n);
  const status = found['/musher/machine_status'].message;
  assert.equal(status.state, 'Active');
  assert.equal(status.epoch, 7n);
  assert.deepEqual(status.actuators.map(actuator => actuator.name), ['', 'audio']);
  assert.deepEqual(status.held_by_stop, ['audio']);
  const joints = found['/joint_states'].message;
  assert.deepEqual(joints.header.stamp, {sec: 1772366405, nanosec: 5});
  assert.deepEqual(joints.name, ['knee', 'hip']);
  assert.deepEqual(Array.from(joints.position), [0.5, -0.25]);
});
