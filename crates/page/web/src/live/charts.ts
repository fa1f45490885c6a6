// Curves of the motion, those that were chosen, with a line at the time that is shown.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { css } from '../colors.js';
import type { Theme } from './types';

interface Curve { name: string; unit: string; values: Float64Array }

/** Curves that are chosen at first. */
const N_FIRST = 3;
const HEIGHT = 190;

export class Charts {
  private times: Float64Array = new Float64Array(0);
  private curves: Curve[] = [];
  private chosen = new Set<string>();
  private plots: uPlot[] = [];
  private colors: Theme['colors'] | null = null;
  private now = 0;
  private key = '';

  constructor(private readonly box: HTMLElement, private readonly list: HTMLElement, private readonly onSeek: (t: number) => void) {}

  paint(colors: Theme['colors']): void {
    this.colors = colors;
    this.show();
  }

  take(times: Float64Array, curves: Curve[]): void {
    this.times = times;
    this.curves = curves;
    const key = curves.map(({ name }) => name).join('\n');
    if (key !== this.key) {
      this.key = key;
      const known = curves.filter(({ name }) => this.chosen.has(name));
      if (known.length === 0) this.chosen = new Set(curves.slice(0, N_FIRST).map(({ name }) => name));
      this.choices();
    }
    this.show();
  }

  /** Time and the chosen curves as columns of a table. */
  columns(): Curve[] {
    const chosen = this.curves.filter(({ name }) => this.chosen.has(name));
    return this.times.length > 0 ? [{ name: 't', unit: 's', values: this.times }, ...chosen] : [];
  }

  /** The values of all curves at a time, by name. */
  at(t: number): Map<string, number> {
    const { times } = this;
    const next = Math.max(1, times.findIndex((own) => own > t));
    const last = times[times.length - 1] <= t ? times.length - 1 : next;
    const part = Math.min(1, Math.max(0, (t - times[last - 1]) / (times[last] - times[last - 1] || 1)));
    return new Map(this.curves.map(({ name, values }) => [name, values[last - 1] + part * (values[last] - values[last - 1])]));
  }

  private choices(): void {
    this.list.replaceChildren(...this.curves.map(({ name, unit }) => {
      const label = document.createElement('label');
      const input = document.createElement('input');
      input.type = 'checkbox';
      input.checked = this.chosen.has(name);
      input.addEventListener('change', () => {
        if (input.checked) this.chosen.add(name);
        else this.chosen.delete(name);
        this.show();
      });
      label.append(input, ` ${name}${unit ? `, ${unit}` : ''}`);
      return label;
    }));
  }

  /** One chart for each unit; nothing while the panel is not seen. */
  show(): void {
    const width = this.box.clientWidth;
    if (width === 0 || !this.colors || this.times.length < 2) return;
    for (const plot of this.plots) plot.destroy();
    this.box.replaceChildren();
    const units = new Map<string, Curve[]>();
    for (const curve of this.curves.filter(({ name }) => this.chosen.has(name))) {
      units.set(curve.unit, [...(units.get(curve.unit) ?? []), curve]);
    }
    this.plots = [...units].map(([unit, curves]) => this.plot(unit, curves, width));
    this.seek(this.now);
  }

  private plot(unit: string, curves: Curve[], width: number): uPlot {
    const { faint, palette } = this.colors as Theme['colors'];
    const axis = { stroke: css(faint), font: '12px system-ui, sans-serif', grid: { stroke: css(faint, 0.25), width: 1 }, ticks: { stroke: css(faint, 0.5), width: 1, size: 5 } };
    const legend = document.createElement('p');
    legend.className = 'legend';
    curves.forEach(({ name }, i) => {
      const sample = document.createElement('i');
      sample.style.background = css(palette[i % palette.length]);
      const entry = document.createElement('span');
      entry.append(sample, name);
      legend.append(entry);
    });
    this.box.append(legend);
    const plot = new uPlot({
      width, height: HEIGHT,
      legend: { show: false },
      scales: { x: { time: false } },
      cursor: { drag: { x: true, y: false, dist: 5 }, points: { size: 6 } },
      series: [{}, ...curves.map((_, i) => ({ stroke: css(palette[i % palette.length]), width: 1.75, points: { show: false } }))],
      axes: [{ ...axis, label: 't, s', labelSize: 18, size: 34, labelFont: axis.font }, { ...axis, size: 62, label: unit || ' ', labelSize: 18, labelFont: axis.font }],
    }, [this.times, ...curves.map(({ values }) => values)] as unknown as uPlot.AlignedData, this.box);
    const line = document.createElement('div');
    line.className = 'now';
    plot.over.append(line);
    plot.over.addEventListener('click', (event) => this.onSeek(plot.posToVal(event.offsetX, 'x')));
    return plot;
  }

  seek(t: number): void {
    this.now = t;
    for (const plot of this.plots) {
      const line = plot.over.querySelector<HTMLElement>('.now');
      if (line) line.style.transform = `translateX(${plot.valToPos(t, 'x')}px)`;
    }
  }
}
