// Files that a reader keeps: the picture as PNG or SVG, the curves as a table.

import type { Charts } from './charts';
import type { Stage } from './stage';
import type { Answer } from './types';

/** Offers a file for download. */
export function download(name: string, content: Blob): void {
  const url = URL.createObjectURL(content);
  const link = document.createElement('a');
  Object.assign(link, { href: url, download: name });
  link.click();
  URL.revokeObjectURL(url);
}

export function savePicture(name: string, canvas: HTMLCanvasElement): void {
  canvas.toBlob((blob) => blob && download(`${name}.png`, blob), 'image/png');
}

export function saveLines(name: string, svg: string): void {
  download(`${name}.svg`, new Blob([svg], { type: 'image/svg+xml' }));
}

export interface Column { name: string; unit: string; values: Float64Array }

/** A table with a heading for each column: name and unit. */
export function saveTable(name: string, columns: Column[]): void {
  if (columns.length === 0) return;
  const cell = (text: string) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  const head = columns.map((column) => cell(column.unit ? `${column.name} [${column.unit}]` : column.name));
  const rows = Array.from(columns[0].values, (_, k) => columns.map(({ values }) => String(values[k])).join(','));
  download(`${name}.csv`, new Blob([`${[head.join(','), ...rows].join('\n')}\n`], { type: 'text/csv' }));
}

/** Everything that can be kept: of the page, its stage, its curves and its text. */
export interface Kept {
  name: string;
  stage: Stage;
  charts: Charts;
  text: string;
  picture(request: object): Promise<Answer<{ svg: string | null }>>;
}

/** Downloads the picture, the curves, or the text. */
export function keep(as: string, { name, stage, charts, text, picture }: Kept): void {
  if (as === 'png') savePicture(name, stage.canvas);
  if (as === 'svg') {
    void picture({ do: 'picture', numbers: Array.from(stage.numbers), view: stage.view }).then(({ json }) => {
      if (json.svg) saveLines(name, json.svg);
    });
  }
  if (as === 'csv') saveTable(name, charts.columns());
  if (as === 'toml') download(`${name}.toml`, new Blob([text], { type: 'application/toml' }));
}
