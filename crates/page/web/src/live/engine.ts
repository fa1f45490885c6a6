// The two threads of the module: one for edits and poses, one for motions and answers, which is ended and begun
// again where a newer text makes its work idle.

import type { Answer } from './types';

/** A motion that takes longer is given up for that of a newer text, ms. */
const PATIENCE = 250;

interface Waiting { done: (answer: Answer<never>) => void; failed: (error: Error) => void }

export class Thread {
  private worker: Worker | null = null;
  private waiting = new Map<number, Waiting>();
  private next = 0;
  private since = 0;

  constructor(private readonly script: string, private readonly code: WebAssembly.Module) {
    this.begin();
  }

  private begin(): void {
    const url = URL.createObjectURL(new Blob([this.script], { type: 'text/javascript' }));
    this.worker = new Worker(url);
    URL.revokeObjectURL(url);
    this.worker.onmessage = ({ data }) => {
      const { id, json, numbers, failure } = data;
      const waiting = this.waiting.get(id);
      this.waiting.delete(id);
      if (failure) waiting?.failed(new Error(failure));
      else waiting?.done({ json, numbers } as Answer<never>);
    };
    this.post({ code: this.code });
  }

  private post<T>(message: object): Promise<Answer<T>> {
    const id = this.next;
    this.next += 1;
    if (this.waiting.size === 0) this.since = performance.now();
    this.worker?.postMessage({ id, ...message });
    return new Promise((done, failed) => {
      this.waiting.set(id, { done: done as Waiting['done'], failed });
    });
  }

  ask<T>(request: object): Promise<Answer<T>> {
    return this.post<T>({ request });
  }

  get isBusy(): boolean {
    return this.waiting.size > 0;
  }

  /** Ends work that has taken too long; what was asked for is never answered. */
  restart(): boolean {
    if (!this.isBusy || performance.now() - this.since < PATIENCE) return false;
    this.worker?.terminate();
    this.waiting.clear();
    this.begin();
    return true;
  }
}

/** Letters of packed bytes, and the values of 13 bits that take a fourteenth: as in `crates/page/src/letters.rs`. */
const BASE = 91;
const SPARE = BASE * BASE - (1 << 13);

/** Bytes from letters: two of them hold 13 or 14 bits. */
function lettersToBytes(text: string): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(Math.ceil((text.length * 14) / 16) + 2);
  const number = (at: number) => {
    const code = text.charCodeAt(at);
    return code - 0x21 - (code > 0x26 ? 1 : 0) - (code > 0x3c ? 1 : 0) - (code > 0x5c ? 1 : 0);
  };
  let [waiting, nBits, n] = [0, 0, 0];
  for (let at = 0; at < text.length; at += 2) {
    const isPair = at + 1 < text.length;
    const value = isPair ? number(at) + BASE * number(at + 1) : number(at);
    const nMore = isPair ? ((value & 0x1fff) < SPARE ? 14 : 13) : 8 - (nBits % 8);
    waiting |= value << nBits;
    nBits += nMore;
    for (; nBits > 7; nBits -= 8) {
      bytes[n] = waiting & 0xff;
      n += 1;
      waiting >>>= 8;
    }
  }
  return bytes.subarray(0, n);
}

/** What was packed into letters, compressed. */
export async function unpacked(text: string): Promise<Response> {
  const stream = new Blob([lettersToBytes(text.trim())]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream);
}
