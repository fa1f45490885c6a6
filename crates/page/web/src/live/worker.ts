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

/** Functions of a browser that libraries declare, for clocks, and that the module never calls. */
function imports(code: WebAssembly.Module): WebAssembly.Imports {
  const found: Record<string, Record<string, WebAssembly.ImportValue>> = {};
  for (const { module: from, name, kind } of WebAssembly.Module.imports(code)) {
    if (kind !== 'function') continue;
    found[from] ??= {};
    found[from][name] = () => { throw new Error(`the module calls ${name}, which it has not`); };
  }
  return found;
}

scope.onmessage = ({ data }) => {
  const { id, request, code } = data as { id: number; request?: unknown; code?: WebAssembly.Module };
  try {
    if (code) {
      module = new WebAssembly.Instance(code, imports(code)).exports as unknown as Exports;
      scope.postMessage({ id, json: {}, numbers: new Float64Array(0) }, []);
      return;
    }
    const found = answer(JSON.stringify(request));
    scope.postMessage({ id, ...found }, [found.numbers.buffer]);
  } catch (error) {
    scope.postMessage({ id, failure: String(error) }, []);
  }
};
