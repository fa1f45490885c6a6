// The equations under the hand: a symbol lights the bodies that it belongs to, and is shown as its number at the pose.

import { numberText } from '../numbers.js';
import { make } from './panels';
import type { Equations, Symbol } from './types';
import { word } from './words';

/** Elements of MathML that may be a symbol, with the number of their parts that are, the others being its power. */
const SYMBOLS = new Map([['mi', 1], ['msub', 2], ['mover', 2], ['msup', 1], ['msubsup', 2]]);
const MATHML = 'http://www.w3.org/1998/Math/MathML';
/** Between factors: nothing that is seen between symbols, a dot between numbers. */
const TIMES = ['\u2062', '·'];

/** A number without zeros at its end. */
function short(value: number): string {
  return numberText(value).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
}

/** Shows equations; `values` gives the values of coordinates and rates now, by name. */
export class Formulas {
  private symbols = new Map<string, Symbol>();
  private marked: { element: Element; symbol: Symbol; written: Node[]; nParts: number }[] = [];
  /** Signs between factors. */
  private times: Element[] = [];
  private isNumeric = false;
  private readonly about = make('p', { class: 'quiet', 'aria-live': 'polite' });
  private readonly list = make('div', {});

  constructor(
    private readonly box: HTMLElement,
    private readonly light: (bodies: number[]) => void,
    private readonly values: () => Promise<Map<string, number>>,
  ) {
    const numbers = make('input', { type: 'checkbox' });
    numbers.addEventListener('change', () => {
      this.isNumeric = numbers.checked;
      void this.refresh();
    });
    this.box.append(make('div', { class: 'formula-head' }, make('label', {}, numbers, ` ${word('Numbers at this pose')}`), this.about), this.list);
    for (const event of ['pointerover', 'click'] as const) this.list.addEventListener(event, ({ target }) => this.look(target as Element));
    this.list.addEventListener('pointerleave', () => this.light([]));
  }

  /** Equations as MathML; they come from the module, which writes names as text. */
  show({ sections = [], remark, symbols = [] }: Equations): void {
    const parser = new DOMParser();
    const parsed = (html: string) => parser.parseFromString(html, 'text/html').body;
    this.symbols = new Map(symbols.map((symbol) => [parsed(`<math>${symbol.html}</math>`).textContent ?? '', symbol]));
    this.marked = [];
    this.list.replaceChildren(...sections.map(({ title, html }) => {
      const body = parsed(html);
      for (const child of body.children) this.mark(child);
      return make('section', {}, make('h3', {}, title), make('div', { class: 'scroll' }, ...body.childNodes));
    }));
    if (remark) this.list.append(make('p', { class: 'quiet' }, remark));
    this.times = [...this.list.querySelectorAll('math mo')].filter(({ textContent }) => textContent === TIMES[0]);
    void this.refresh();
  }

  /** Marks the symbols in formulas, each once, without its power; what stands before an equation names it. */
  private mark(element: Element): void {
    const n = SYMBOLS.get(element.tagName.toLowerCase());
    if (element.matches('table, math > mtable > mtr > mtd:first-child')) return;
    if (n !== undefined) {
      const parts = element.children.length > 0 ? [...element.children].slice(0, n) : [element];
      const symbol = this.symbols.get(parts.map(({ textContent }) => textContent).join(''));
      if (symbol) {
        element.setAttribute('data-symbol', symbol.name);
        this.marked.push({ element, symbol, written: [...element.childNodes], nParts: n });
        return;
      }
    }
    for (const child of element.children) this.mark(child);
  }

  private look(target: Element): void {
    const name = target.closest('[data-symbol]')?.getAttribute('data-symbol');
    const symbol = [...this.symbols.values()].find((own) => own.name === name);
    this.light(symbol?.bodies ?? []);
    if (!symbol) return;
    void this.values().then((values) => {
      const value = symbol.value ?? values.get(symbol.name);
      this.about.textContent = value === undefined ? symbol.name : `${symbol.name} = ${short(value)}`;
    });
  }

  /** Writes numbers for symbols, or symbols again. */
  async refresh(): Promise<void> {
    const values = this.isNumeric ? await this.values() : new Map<string, number>();
    for (const sign of this.times) sign.textContent = TIMES[this.isNumeric ? 1 : 0];
    for (const { element, symbol, written, nParts } of this.marked) {
      const value = this.isNumeric ? symbol.value ?? values.get(symbol.name) : undefined;
      element.classList.toggle('valued', value !== undefined);
      if (value === undefined) {
        if (element.childNodes[0] !== written[0]) element.replaceChildren(...written);
        continue;
      }
      const words = value < 0 ? `(${short(value)})` : short(value);
      if (element.children.length === 0 && written[0] instanceof window.Text) {
        element.replaceChildren(words);
        continue;
      }
      // The number takes the place of the name, nothing that of its index or dot; the power stays.
      const made = (tag: string) => document.createElementNS(MATHML, tag);
      const number = made('mn');
      number.textContent = words;
      const empty = Array.from({ length: nParts - 1 }, () => made('mrow'));
      element.replaceChildren(number, ...empty, ...written.slice(nParts));
    }
  }

  get isShown(): boolean {
    return this.isNumeric;
  }
}
