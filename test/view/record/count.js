// How many messages a recording has, by the library of MCAP: node count.js FILE
import {open} from 'node:fs/promises';
import {McapIndexedReader} from '@mcap/core';
import {loadDecompressHandlers} from './decompress.js';

const file = await open(process.argv[2]);
const reader = await McapIndexedReader.Initialize({decompressHandlers: loadDecompressHandlers(), readable: {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const {buffer} = await file.read(new Uint8Array(Number(size)), 0, Number(size), Number(offset));
    return buffer;
  },
}});
let count = 0;
for await (const message of reader.readMessages({validateCrcs: true})) count += message ? 1 : 0;
await file.close();
console.log(count);
