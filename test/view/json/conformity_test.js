// Every type of the IDL: the library with which Foxglove reads ROS 2's messages takes the definition and the
// bytes that MessageJson has written, finds the values that it has found, and writes the same bytes again.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import path from 'node:path';
import {test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {parse} from '@foxglove/rosmsg';
import {MessageReader, MessageWriter} from '@foxglove/rosmsg2-serialization';

const here = path.dirname(fileURLToPath(import.meta.url));
const program = path.join(process.env.MUSHER_BIN ?? path.resolve(here, '../../../build/dev/bin'),
  'view_json_samples');
const lines = execFileSync(program, {maxBuffer: 64 << 20}).toString().trimEnd().split('\n').map(JSON.parse);

// A value of the library as MessageJson writes it.
function plain(value) {
  if (typeof value === 'bigint') {
    return value > 2n ** 53n || value < -(2n ** 53n) ? value.toString() : Number(value);
  }
  if (typeof value === 'number') return Number.isFinite(value) ? value : null;
  if (ArrayBuffer.isView(value) || Array.isArray(value)) return Array.from(value, plain);
  if (value !== null && typeof value === 'object') {
    return Object.fromEntries(Object.entries(value).map(([key, each]) => [key, plain(each)]));
  }
  return value;
}

// A float32 is written in its shortest form; the library gives it as a float64.
function same(a, b) {
  if (typeof a === 'number' && typeof b === 'number') return a === b || Math.fround(a) === Math.fround(b);
  if (a === null || b === null || typeof a !== 'object' || typeof b !== 'object') return a === b;
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every(name => same(a[name], b[name]));
}

test('there are types', () => assert.ok(lines.length > 100));

for (const {type, definition, bytes, json} of lines) {
  test(type, () => {
    const parsed = parse(definition, {ros2: true});
    const message = new MessageReader(parsed).readMessage(Buffer.from(bytes, 'hex'));
    const read = plain(message);
    assert.ok(same(read, JSON.parse(json)), `${JSON.stringify(read)}\n${json}`);
    assert.equal(Buffer.from(new MessageWriter(parsed).writeMessage(message)).toString('hex'), bytes);
  });
}
