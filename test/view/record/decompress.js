// What the library of MCAP needs to read compressed chunks.
import {createRequire} from 'node:module';
import {decompress as zstd} from 'fzstd';

const lz4 = createRequire(import.meta.url)('lz4js');

export function loadDecompressHandlers() {
  return {
    zstd: (bytes, size) => zstd(bytes, new Uint8Array(Number(size))),
    lz4: (bytes, size) => Uint8Array.from(lz4.decompress(bytes, Number(size))),
  };
}
