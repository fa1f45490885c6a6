// What a model is, and the pages about it; nothing here needs an editor.

/** Headers that files of other programs do not have. */
const OWN = /^\s*\[(bodies|joints|loads|drives|couplings)[.\]]/m;

/** Whether the text of a TOML file is that of a model. */
export function isModel(text: string): boolean {
  return OWN.test(text);
}

/** The scheme of pages about diagnostic codes. */
export const PAGES = "bksim-page";

/** The code that the address of a page names: `bksim-page:/M012.md`. */
export function codeOf(path: string): string | undefined {
  return /^\/?([A-Z]\d{3})\.md$/.exec(path)?.[1];
}

/** A document of equations as bksim writes it, in the colours of the editor and without scripts. */
export function equationsPage(html: string): string {
  const policy =
    `<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">` +
    `<style>body { color: var(--vscode-editor-foreground); background: var(--vscode-editor-background); }` +
    ` math { font-size: 1.1em; }</style>`;
  // After the document's own style, which it comes before.
  return html.includes("</head>") ? html.replace("</head>", `${policy}</head>`) : policy + html;
}
