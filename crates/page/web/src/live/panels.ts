// The panels next to the picture: values with sliders, elements with their keys, faults, freedoms, equations, ways.

import { codeWords, word } from './words';
import type { Control, Element, Fault, Freedoms, Limits, State, Transmission, Ways } from './types';

type Change = (path: string, value: string, isMoving: boolean) => void;

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  of: Partial<Record<string, string>> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(of)) if (value !== undefined) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** A number as a slider gives it: no digits of rounding. */
function short(x: number): string {
  return String(Number(x.toPrecision(6)));
}

const KINDS: Record<string, string> = { parameters: 'Parameters', drives: 'Drives', initial: 'Start', solve: 'Time' };

/** Sliders and fields of all values; they keep the focus while the text changes under them. */
export class Values {
  private rows = new Map<string, { control: Control; field: HTMLInputElement; slider: HTMLInputElement | null }>();

  constructor(private readonly box: HTMLElement, private readonly change: Change, private readonly settle: () => void) {}

  show(controls: Control[]): void {
    const isSame = controls.length > 0 && controls.length === this.rows.size && controls.every(({ path, number }) => {
      const row = this.rows.get(path);
      return row && (row.slider !== null) === (number !== undefined);
    });
    if (isSame) {
      for (const control of controls) this.update(control);
      return;
    }
    this.rows.clear();
    this.box.replaceChildren();
    for (const [kind, title] of Object.entries(KINDS)) {
      const some = controls.filter((control) => control.kind === kind && !control.is_guess);
      if (some.length === 0) continue;
      const rows = some.map((control) => this.row(control));
      this.box.append(make('fieldset', {}, make('legend', {}, word(title)), ...rows));
    }
    // Where the search of the pose begins matters seldom.
    const guesses = controls.filter((control) => control.is_guess).map((control) => this.row(control));
    if (guesses.length > 0) this.box.append(make('details', {}, make('summary', {}, word('Guesses of the start')), ...guesses));
    if (controls.length === 0) this.box.append(word('No values yet: draw a link.'));
  }

  private update(control: Control): void {
    const row = this.rows.get(control.path);
    if (!row) return;
    row.control = control;
    if (document.activeElement !== row.field) row.field.value = control.text;
    const { slider } = row;
    if (slider && control.range && document.activeElement !== slider) {
      const [low, high, step] = control.range;
      // A range stays as long as it holds the number: sliders do not run away from the hand.
      const x = control.number ?? 0;
      if (control.is_stated || x < Number(slider.min) || x > Number(slider.max)) {
        Object.assign(slider, { min: String(low), max: String(high), step: String(step) });
      }
      slider.value = String(x);
    }
  }

  private row(control: Control): HTMLElement {
    const { path, name, text, range, is_guess } = control;
    const field = make('input', { type: 'text', value: text, spellcheck: 'false', autocomplete: 'off', 'aria-label': `${name}, value` });
    field.addEventListener('change', () => this.change(path, field.value, false));
    let slider: HTMLInputElement | null = null;
    if (range) {
      const [low, high, step] = range;
      slider = make('input', { type: 'range', min: String(low), max: String(high), step: String(step), 'aria-label': name });
      slider.value = String(control.number);
      slider.addEventListener('input', () => {
        const unit = this.rows.get(path)?.control.unit ?? '';
        const value = `${short(Number(slider?.value))} ${unit}`.trim();
        field.value = value;
        this.change(path, value, true);
      });
      slider.addEventListener('change', () => this.settle());
    }
    this.rows.set(path, { control, field, slider });
    const label = make('span', { class: 'name', title: path }, is_guess ? `${name} (${word('guess')})` : name);
    return make('div', { class: 'row', 'data-path': path }, label, slider ?? make('span'), field);
  }
}

/** Elements with all their keys. */
export class Elements {
  private shown = '';

  constructor(
    private readonly box: HTMLElement,
    private readonly change: Change,
    private readonly act: (edit: { edit: string } & Record<string, string>) => void,
  ) {}

  show(elements: Element[]): void {
    const key = JSON.stringify(elements);
    if (key === this.shown) return;
    this.shown = key;
    const open = new Set([...this.box.querySelectorAll('details[open]')].map((d) => d.getAttribute('data-name')));
    const active = document.activeElement?.getAttribute('data-path');
    this.box.replaceChildren(...elements.map((element) => this.element(element, open)));
    if (elements.length === 0) this.box.append(word('Nothing yet: choose the tool Link and click twice.'));
    if (active) this.box.querySelector<HTMLElement>(`[data-path="${CSS.escape(active)}"]`)?.focus();
  }

  private element({ section, name, keys, more }: Element, open: Set<string | null>): HTMLElement {
    const rows = keys.map(({ path, key, text }) => {
      const field = make('input', { type: 'text', value: text, spellcheck: 'false', autocomplete: 'off', 'data-path': path, 'aria-label': `${name}, ${key}` });
      field.addEventListener('change', () => this.change(path, field.value, false));
      return make('label', { class: 'row two' }, make('span', { class: 'name' }, key), field);
    });
    const parts: HTMLElement[] = [...rows];
    if (more.length > 0) parts.push(this.another(section, name, more));
    if (section !== 'ground') {
      const rename = make('input', { type: 'text', value: name, 'aria-label': `New name of ${name}`, spellcheck: 'false' });
      rename.addEventListener('change', () => this.act({ edit: 'rename', name, to: rename.value }));
      const remove = make('button', { type: 'button', class: 'plain' }, word('Delete'));
      remove.addEventListener('click', () => this.act({ edit: 'delete', name }));
      parts.unshift(make('div', { class: 'row two' }, make('span', { class: 'name' }, 'name'), make('span', { class: 'both' }, rename, remove)));
    }
    const details = make('details', { 'data-name': name }, make('summary', {}, make('b', {}, name), ` ${section}`), ...parts);
    details.open = open.has(name);
    return details;
  }

  /** A row for a key that is not given yet. */
  private another(section: string, name: string, more: string[]): HTMLElement {
    const keys = make('select', { 'aria-label': `New key of ${name}` }, make('option', { value: '' }, word('another key')), ...more.map((key) => make('option', { value: key }, key)));
    const field = make('input', { type: 'text', spellcheck: 'false', autocomplete: 'off', disabled: '', 'aria-label': `${name}, value of the new key` });
    keys.addEventListener('change', () => {
      field.disabled = keys.value === '';
      if (!field.disabled) field.focus();
    });
    field.addEventListener('change', () => this.change([section, ...(section === 'ground' ? [] : [name]), keys.value].join('.'), field.value, false));
    return make('div', { class: 'row two' }, keys, field);
  }
}

/** Faults with their places; a click goes to the text. */
export function showFaults(box: HTMLElement, faults: Fault[], goTo: (from: number, to: number) => void): void {
  box.replaceChildren(...faults.map((fault) => {
    const first = fault.labels[0];
    const place = first ? `${word('line')} ${first.line}: ` : '';
    const known = codeWords(fault.code);
    const head = make('button', { type: 'button', class: 'plain', title: known?.[1] }, make('b', {}, fault.code), ` ${place}${known?.[0] ?? fault.message}`);
    head.addEventListener('click', () => first && goTo(first.from, first.to));
    const item = make('li', { class: fault.is_error ? 'error' : 'warning' }, head);
    if (known) item.append(make('p', { lang: 'en' }, fault.message), make('p', {}, `${word('help')}: ${known[2]}`));
    else if (fault.help) item.append(make('p', {}, `${word('help')}: ${fault.help}`));
    return item;
  }));
  box.hidden = faults.length === 0;
}

export function showFreedoms(box: HTMLElement, found: Freedoms): void {
  if (found.mobility === undefined) {
    box.textContent = '';
    return;
  }
  const { gruebler = 0, mobility, redundant_conditions: repeated = 0, redundant_joints: joints = [], drives = 0 } = found;
  const say = (words: string, n: number) => word(words).replace('#', String(n));
  const count = mobility === 1 ? word('1 free motion') : say('# free motions', mobility);
  const driven = drives > 0 ? `, ${drives === 1 ? word('one driven') : say('# driven', drives)}` : '';
  const formula = gruebler === mobility ? '' : say('; Grübler’s formula counts #', gruebler);
  const more = repeated > 0 ? `${say(repeated === 1 ? '; # redundant condition' : '; # redundant conditions', repeated)} (${joints.join(', ')})` : '';
  box.textContent = `${count}${driven}${formula}${more}`;
}

/** Angles below this, degrees, transmit badly: Alt's limit. */
const LEAST_ANGLE = 40;

/** Transmission angles of the pose; the least stands out where it is small. */
export function showTransmissions(box: HTMLElement, found: Transmission[]): void {
  box.replaceChildren(...found.map(({ at, degrees }) =>
    make('span', degrees < LEAST_ANGLE ? { class: 'low' } : {}, `${word('transmission angle')} ${at}: ${degrees.toFixed(1)}°`)));
}

export function showLimits(box: HTMLElement, { tables = [], beyond = [], refused }: Limits): void {
  const shown = tables.map(({ title, heads, rows }) => {
    const row = (tag: 'th' | 'td', cells: string[]) => make('tr', {}, ...cells.map((cell) => make(tag, {}, tag === 'th' ? word(cell) : cell)));
    return make('section', {}, make('h3', {}, word(title)), make('div', { class: 'scroll' }, make('table', {}, row('th', heads), ...rows.map((cells) => row('td', cells)))));
  });
  box.replaceChildren(...shown);
  if (beyond.length > 0) box.append(make('p', { class: 'quiet' }, `${word('Not kept to')}: ${beyond.join(', ')}`));
  if (refused) box.append(make('p', { class: 'quiet' }, refused));
}

export function showWays(box: HTMLElement, { assemblies = [], held = [] }: Ways, choose: (number: number) => void, look: (place: number | null) => void): void {
  const heading = make('p', { class: 'quiet' }, assemblies.length === 0 ? 'None was found.' : `With ${held.join(', ') || 'nothing'} held, the joints close in ${assemblies.length === 1 ? 'one way' : `${assemblies.length} ways`}.`);
  const items = assemblies.map(({ number, name }, place) => {
    const button = make('button', { type: 'button', class: 'plain wide' }, `${number}. ${name}`);
    button.addEventListener('click', () => choose(number));
    button.addEventListener('pointerenter', () => look(place));
    button.addEventListener('focus', () => look(place));
    for (const end of ['pointerleave', 'blur']) button.addEventListener(end, () => look(null));
    return make('li', {}, button);
  });
  box.replaceChildren(heading, make('ol', { class: 'ways' }, ...items));
}

/** The text of the model in a field, with its faults marked by their lines. */
export class Text {
  private timer = 0;

  constructor(private readonly field: HTMLTextAreaElement, private readonly lines: HTMLElement, change: (text: string) => void) {
    field.addEventListener('input', () => {
      window.clearTimeout(this.timer);
      this.timer = window.setTimeout(() => change(field.value), 250);
      this.number();
    });
    field.addEventListener('scroll', () => { this.lines.scrollTop = field.scrollTop; });
    field.addEventListener('keydown', (event) => {
      if (event.key !== 'Tab' || event.shiftKey || event.ctrlKey) return;
      // Escape first, and Tab leaves the field as everywhere.
      if (field.dataset.leaves) return;
      event.preventDefault();
      field.setRangeText('  ', field.selectionStart, field.selectionEnd, 'end');
      field.dispatchEvent(new InputEvent('input'));
    });
    field.addEventListener('keyup', ({ key }) => {
      if (key === 'Escape') field.dataset.leaves = 'yes';
    });
    field.addEventListener('focus', () => delete field.dataset.leaves);
  }

  show({ text, faults }: State): void {
    // What is being typed stays as it is.
    if (this.field.value !== text && document.activeElement !== this.field) this.field.value = text;
    this.number(faults);
  }

  private number(faults: Fault[] = []): void {
    const marked = new Map<number, boolean>();
    for (const { labels, is_error } of faults) {
      for (const { line } of labels.slice(0, 1)) marked.set(line, marked.get(line) || is_error);
    }
    const n = this.field.value.split('\n').length;
    this.lines.replaceChildren(...Array.from({ length: n }, (_, i) => {
      const mark = marked.get(i + 1);
      const kind = mark === undefined ? undefined : mark ? 'error' : 'warning';
      return make('div', kind ? { class: kind } : {}, String(i + 1));
    }));
    this.lines.scrollTop = this.field.scrollTop;
  }

  goTo(from: number, to: number): void {
    this.field.focus();
    this.field.setSelectionRange(from, to);
    const line = this.field.value.slice(0, from).split('\n').length - 1;
    this.field.scrollTop = Math.max(0, line * 18 - 60);
  }
}
