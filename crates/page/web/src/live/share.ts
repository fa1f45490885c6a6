// A model in the fragment of a link: compressed, in the letters that addresses allow; and the panels that are shown.
//
//   #model=…                 the model
//   #panels=play,values      these parts alone, for a page in a frame
//   #lang=vi                 the language

const NAME = 'model=';

async function through(bytes: Uint8Array<ArrayBuffer>, stream: ReadableWritablePair<Uint8Array<ArrayBuffer>, BufferSource>): Promise<Uint8Array<ArrayBuffer>> {
  const piped = new Blob([bytes]).stream().pipeThrough(stream);
  return new Uint8Array(await new Response(piped).arrayBuffer());
}

/** The fragment of a text, `#` left out. */
export async function fragmentOf(text: string): Promise<string> {
  const packed = await through(new TextEncoder().encode(text), new CompressionStream('deflate-raw'));
  let binary = '';
  for (const byte of packed) binary += String.fromCharCode(byte);
  return NAME + btoa(binary).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
}

/** A part of a fragment by its name. */
export function partOf(fragment: string, name: string): string | null {
  const parts = fragment.replace(/^#/, '').split('&');
  return parts.find((part) => part.startsWith(`${name}=`))?.slice(name.length + 1) ?? null;
}

/** The text in a fragment; `null` where there is none, or it is damaged. */
export async function textOf(fragment: string): Promise<string | null> {
  const found = partOf(fragment, 'model');
  if (found === null) return null;
  try {
    const binary = atob(found.replace(/-/g, '+').replace(/_/g, '/'));
    const bytes = Uint8Array.from(binary, (c) => c.charCodeAt(0));
    return new TextDecoder('utf-8', { fatal: true }).decode(await through(bytes, new DecompressionStream('deflate-raw')));
  } catch {
    return null;
  }
}
