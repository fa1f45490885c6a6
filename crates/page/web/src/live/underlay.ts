// A picture or drawing under the mechanism, to draw over: two clicks and a length scale it.

import type { Camera } from '../camera.js';
import { element } from '../controls.js';
import type { World } from './types';

/** Lines of a drawing and places worth meeting on it, m: x and y in turn. */
export interface Outlines { lines: number[][]; places: number[] }

export class Underlay {
  private image: ImageBitmap | null = null;
  /** Metres for each pixel of the picture, and the place of its upper left corner. */
  private scale = 1;
  private corner: [number, number] = [0, 0];

  constructor(private outlines: Outlines | null) {}

  private at(points: number[], i: number): [number, number] {
    return [this.corner[0] + this.scale * points[i], this.corner[1] + this.scale * points[i + 1]];
  }

  /** The nearest end or centre of the drawing within a distance. */
  near([x, y]: World, reach: number): World | null {
    const { places = [] } = this.outlines ?? {};
    let [best, least]: [World | null, number] = [null, reach];
    for (let i = 0; i < places.length; i += 2) {
      const [px, py] = this.at(places, i);
      const distance = Math.hypot(px - x, py - y);
      if (distance < least) [best, least] = [[px, py, 0], distance];
    }
    return best;
  }

  /** All corners of the drawing. */
  corners(): number[][] {
    return (this.outlines?.lines ?? []).flatMap((line) => line.flatMap((_, i) => (i % 2 ? [] : [[...this.at(line, i), 0]])));
  }

  /** Wires the button that takes a picture or removes it, with its field for files. */
  wire(camera: Camera, redraw: () => void, taken: (isThere: boolean) => void): void {
    const field = element('underlay') as HTMLInputElement;
    element('under').addEventListener('click', () => {
      if (!this.image && !this.outlines) {
        field.click();
        return;
      }
      [this.image, this.outlines] = [null, null];
      redraw();
    });
    field.addEventListener('change', () => {
      const [file] = field.files ?? [];
      field.value = '';
      if (file) void this.take(file, camera).then(() => taken(true), () => taken(false));
    });
  }

  /** Takes a picture, as large as the view is. */
  private async take(file: Blob, camera: Camera): Promise<void> {
    const image = await createImageBitmap(file);
    this.image = image;
    const [width, height] = camera.size;
    this.scale = Math.min(width / image.width, height / image.height) / camera.scale;
    this.corner = [
      camera.centre[0] - 0.5 * this.scale * image.width,
      camera.centre[1] + 0.5 * this.scale * image.height,
    ];
  }

  /** Scales the picture about the first of two of its places, so that they have this distance, m. */
  measure(from: World, to: World, distance: number): void {
    const shown = Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (!(shown > 0 && distance > 0)) return;
    const factor = distance / shown;
    this.scale *= factor;
    this.corner = [0, 1].map((i) => from[i] + factor * (this.corner[i] - from[i])) as [number, number];
  }

  paint(context: CanvasRenderingContext2D, camera: Camera, colour: string): void {
    const { image, scale, corner } = this;
    context.save();
    context.globalAlpha = 0.45;
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.beginPath();
    for (const line of this.outlines?.lines ?? []) {
      for (let i = 0; i < line.length; i += 2) {
        const [x, y] = camera.project([...this.at(line, i), 0]);
        if (i === 0) context.moveTo(x, y);
        else context.lineTo(x, y);
      }
    }
    context.stroke();
    context.restore();
    if (!image) return;
    const [x, y] = camera.project([corner[0], corner[1], 0]);
    const [width, height] = [image.width, image.height].map((n) => n * scale * camera.scale);
    context.save();
    context.globalAlpha = 0.4;
    context.drawImage(image, x, y, width, height);
    context.restore();
  }
}

/** Metres of a length as people write it: `120 mm`, `3.5 in`, `0.2`. */
export function metresOf(text: string): number | null {
  const found = /^\s*([0-9]*\.?[0-9]+(?:e[-+]?[0-9]+)?)\s*(mm|cm|m|in|ft)?\s*$/i.exec(text);
  if (!found) return null;
  const units: Record<string, number> = { mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254, ft: 0.3048 };
  return Number(found[1]) * units[(found[2] ?? 'm').toLowerCase()];
}
