// The page in a frame of lecture notes: the parts that its address names.

import { element } from '../controls.js';

/** Shows these parts alone: header, tools, play, and panels by the names of their tabs. */
export function embed(names: string[], openTab: (name: string) => void): void {
  const isShown = (name: string) => names.includes(name);
  document.documentElement.dataset.embedded = 'yes';
  document.querySelector('header')?.toggleAttribute('hidden', !isShown('header'));
  document.querySelector('footer')?.toggleAttribute('hidden', !isShown('header'));
  document.querySelector('.tools')?.toggleAttribute('hidden', !isShown('tools'));
  element('transport').toggleAttribute('hidden', !isShown('play'));
  const tabs = [...document.querySelectorAll<HTMLElement>('[role=tab]')];
  for (const button of tabs) button.hidden = !isShown(button.dataset.tab ?? '');
  const first = tabs.find((button) => !button.hidden);
  element('side').toggleAttribute('hidden', !first);
  if (first) openTab(first.dataset.tab ?? 'values');
}

interface Shown { text: string; time: number; selected: string }

/** A page in the cell of a notebook: what is shown goes out to the frame's owner, and a text that it sends comes in. */
export class Frame {
  private readonly isFramed = window.parent !== window;
  private told = '';

  constructor(private readonly shown: () => Shown, take: (text: string) => void) {
    if (!this.isFramed) return;
    window.addEventListener('message', ({ source, data }) => {
      const text: unknown = data?.bksim?.text;
      if (source === window.parent && typeof text === 'string' && text !== this.shown().text) take(text);
    });
  }

  tell(): void {
    if (!this.isFramed) return;
    const shown = this.shown();
    const now = JSON.stringify(shown);
    if (now === this.told) return;
    this.told = now;
    window.parent.postMessage({ bksim: shown }, '*');
  }
}
