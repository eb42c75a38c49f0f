// The layout files for Foxglove: each panel that a layout places is described, and the other way round.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync} from 'node:fs';
import path from 'node:path';
import {test} from 'node:test';
import {fileURLToPath} from 'node:url';

const folder = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../../docs/foxglove');
const placed = layout => (typeof layout === 'string' ? [layout]
  : [...placed(layout.first), ...placed(layout.second)]);

for (const name of readdirSync(folder)) {
  test(name, () => {
    const {configById, layout} = JSON.parse(readFileSync(path.join(folder, name), 'utf8'));
    assert.deepEqual(placed(layout).sort(), Object.keys(configById).sort());
    for (const id of placed(layout)) assert.match(id, /^[A-Za-z0-9]+!\w+$/);
  });
}
