// The module in a thread of its own: requests in, answers out, in the order in which they came.

interface Exports { memory: WebAssembly.Memory; request(n: number): number; answer(): number }

const scope = self as unknown as {
  onmessage: ((event: MessageEvent) => void) | null;
  postMessage(message: unknown, transfer: Transferable[]): void;
};
let module: Exports | null = null;

function answer(request: string): { json: unknown; numbers: Float64Array } {
  const { memory, request: room, answer: ask } = module as Exports;
  const bytes = new TextEncoder().encode(request);
  // Making room may grow the memory, which gives it another buffer.
  const to = room(bytes.length);
  new Uint8Array(memory.buffer, to, bytes.length).set(bytes);
  const at = ask();
  const [nJson, nNumbers] = new Uint32Array(memory.buffer, at, 2);
  const json = new TextDecoder().decode(new Uint8Array(memory.buffer, at + 8, nJson));
  const first = at + 8 + 8 * Math.ceil(nJson / 8);
  const numbers = new Float64Array(memory.buffer, first, nNumbers).slice();
  return { json: JSON.parse(json), numbers };
}

scope.onmessage = ({ data }) => {
  const { id, request, code } = data as { id: number; request?: unknown; code?: WebAssembly.Module };
  try {
    if (code) {
      module = new WebAssembly.Instance(code, {}).exports as unknown as Exports;
      scope.postMessage({ id, json: {}, numbers: new Float64Array(0) }, []);
      return;
    }
    const found = answer(JSON.stringify(request));
    scope.postMessage({ id, ...found }, [found.numbers.buffer]);
  } catch (error) {
    scope.postMessage({ id, failure: String(error) }, []);
  }
};
