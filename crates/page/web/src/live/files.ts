// Files that a reader keeps: the picture as PNG or SVG, the curves as a table.

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
