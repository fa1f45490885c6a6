// The module of live pages beside the library: poses and motions of all examples, by what the test writes into
//
//   BKSIM_LIVE_MOTIONS   a JSON file: {"module": file, "examples": [{"name", "text", "start": […], "end": […]}]}

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';

const plan = process.env.BKSIM_LIVE_MOTIONS && JSON.parse(fs.readFileSync(process.env.BKSIM_LIVE_MOTIONS, 'utf8'));
const skip = plan ? false : 'no module of live pages';

/** The module, and its answer to a request. */
async function opened(file) {
  const code = await WebAssembly.compile(fs.readFileSync(file));
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(code)) {
    imports[from] ??= {};
    imports[from][name] = () => { throw new Error(`the module calls ${name}`); };
  }
  const { memory, request: room, answer } = (await WebAssembly.instantiate(code, imports)).exports;
  return (request) => {
    const bytes = new TextEncoder().encode(JSON.stringify(request));
    const to = room(bytes.length);
    new Uint8Array(memory.buffer, to, bytes.length).set(bytes);
    const at = answer();
    const [nJson, nNumbers] = new Uint32Array(memory.buffer, at, 2);
    const json = JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, at + 8, nJson)));
    return { json, numbers: new Float64Array(memory.buffer, at + 8 + 8 * Math.ceil(nJson / 8), nNumbers).slice() };
  };
}

/** Motions whose impacts multiply the rounding of other processors' functions, and what becomes of 1e-16 in them, m. */
const AMPLIFIED = { 'pin-with-play': 1e-4 };

/** Largest difference of places and directions. */
function difference(a, b) {
  assert.equal(a.length, b.length);
  return a.reduce((most, x, k) => (k % 18 < 12 ? Math.max(most, Math.abs(x - b[k])) : most), 0);
}

test('the module moves every example as the library does', { skip }, async () => {
  const ask = await opened(plan.module);
  let nQuick = 0;
  const off = [];
  for (const { name, text, start, end } of plan.examples) {
    const state = ask({ do: 'open', text, name });
    const atStart = difference(state.numbers, start);
    // As a page solves after a change: the equations are known.
    ask({ do: 'solve' });
    const began = performance.now();
    const { json, numbers } = ask({ do: 'solve' });
    const took = performance.now() - began;
    nQuick += took < 100 ? 1 : 0;
    const nNumbers = 18 * json.scene.bodies.length;
    const last = json.n_frames * (1 + json.curves.length + nNumbers) - nNumbers;
    const atEnd = difference(numbers.subarray(last, last + nNumbers), end);
    console.log(`# ${name}: ${took.toFixed(0)} ms, start ${atStart.toExponential(1)}, end ${atEnd.toExponential(1)}`);
    if (!(atStart < 1e-9 && atEnd < (AMPLIFIED[name] ?? 1e-9))) off.push([name, atStart, atEnd]);
  }
  assert.deepEqual(off, []);
  console.log(`# ${nQuick} of ${plan.examples.length} solved anew within 100 ms`);
});
