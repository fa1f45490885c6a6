// The curves: one chart for each unit among the chosen channels, all with the same time axis and a line
// at the current time.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import { css } from './colors.js';
import { decoded } from './motion.js';
import { numberText, tickTexts } from './numbers.js';
import { isWithin } from './spans.js';

/** Dashes, which distinguish curves of one colour once the palette is used up. */
const DASHES = [undefined, [8, 4], [2, 3]];
/** The dash of values that are one of many solutions of the equilibrium. */
const SHARED_DASH = [4, 4];
const HEIGHT = 190;
/** Distance from the line, pixels, within which a drag moves it. */
const NEAR = 12;
/** Relative size of rounding errors of zero, against a curve's largest value. */
const ROUNDING = 2 ** -23;

export class Curves {
  /** `container` gets the charts; `onSeek(t)` is called when the line is moved. */
  constructor({ times, channels }, container, onSeek) {
    this.times = decoded(times, Float64Array);
    this.channels = channels.map(({ values, constant, ...rest }) => ({
      ...rest,
      values: values
        ? decoded(values, Float32Array)
        : new Float32Array(this.times.length).fill(constant ?? NaN),
    }));
    for (const channel of this.channels) channel.largest = largestOf(channel.values);
    this.container = container;
    this.onSeek = onSeek;
    this.charts = [];
    this.chosen = overview(this.channels);
    this.now = this.times[0];
  }

  /** Replaces the charts by those of the chosen channels. */
  show(theme) {
    this.theme = theme;
    for (const { plot } of this.charts) plot.destroy();
    this.container.replaceChildren();
    const byUnit = new Map();
    for (const channel of this.chosen) {
      byUnit.set(channel.unit, [...(byUnit.get(channel.unit) ?? []), channel]);
    }
    const units = [...byUnit.entries()];
    this.charts = units.map(([unit, channels], i) =>
      this.chart(unit, channels, i === units.length - 1),
    );
    if (units.length === 0) this.container.textContent = 'No curve is chosen.';
    this.seek(this.now);
  }

  color(i) {
    const { palette } = this.theme.colors;
    return css(palette[i % palette.length]);
  }

  chart(unit, channels, isLast) {
    const figure = document.createElement('figure');
    const legend = document.createElement('figcaption');
    const box = document.createElement('div');
    figure.append(legend, box);
    this.container.append(figure);
    const values = channels.map((channel, i) => {
      const entry = document.createElement('span');
      const name = document.createElement('b');
      name.textContent = channel.name;
      name.title = channel.description;
      const sample = document.createElement('i');
      sample.style.background = this.color(i);
      const value = document.createElement('span');
      value.className = 'value';
      const remark = document.createElement('span');
      remark.className = 'shared';
      remark.title = 'One of many solutions of the equilibrium; dashed in the chart';
      entry.append(sample, name, remark, value);
      legend.append(entry);
      return { value, remark };
    });
    const { faint } = this.theme.colors;
    const axis = {
      stroke: css(faint),
      font: '12px system-ui, sans-serif',
      grid: { stroke: css(faint, 0.25), width: 1 },
      ticks: { stroke: css(faint, 0.5), width: 1, size: 5 },
    };
    const options = {
      width: this.width(),
      height: HEIGHT + (isLast ? 22 : 0),
      legend: { show: false },
      scales: { x: { time: false } },
      cursor: { sync: { key: 'run' }, drag: { x: true, y: false, dist: 5 }, points: { size: 6 } },
      series: [
        {},
        ...channels.flatMap((channel, i) => {
          const all = DASHES[Math.floor(i / this.theme.colors.palette.length) % DASHES.length];
          return this.parts(channel).map(({ isShared }) => ({
            stroke: this.color(i),
            width: 1.75,
            pxAlign: 0,
            dash: isShared ? SHARED_DASH : all,
            points: { show: false },
          }));
        }),
      ],
      axes: [
        { ...axis, label: isLast ? 't, s' : undefined, labelSize: 20, size: isLast ? 36 : 24,
          labelFont: axis.font },
        { ...axis, size: 62, label: printed(unit) || ' ', labelSize: 18, labelFont: axis.font,
          values: (_, ticks) => tickTexts(ticks) },
      ],
      hooks: { setScale: [(plot, key) => key === 'x' && this.zoomed(plot)] },
    };
    const parts = channels.flatMap((channel) => this.parts(channel));
    const data = [this.times, ...parts.map(({ values }) => values)];
    const plot = new uPlot(options, data, box);
    const line = document.createElement('div');
    line.className = 'now';
    plot.over.append(line);
    this.listen(plot);
    return { plot, line, channels, values };
  }

  /** A curve as it is, or where it is unique and where it is not; the parts meet where that changes. */
  parts({ values, shared }) {
    if (shared.length === 0) return [{ values, isShared: false }];
    const isIn = (t) => isWithin(shared, t);
    const isInside = (t) => shared.some(([from, to]) => t > from && t < to);
    const [first, last] = [this.times[0], this.times.at(-1)];
    const isUnique = (t) => !isInside(t) && !(isIn(t) && (t === first || t === last));
    const part = (isShared, has) => ({
      values: Array.from(values, (value, k) => (has(this.times[k]) ? value : null)),
      isShared,
    });
    return [part(false, isUnique), part(true, isIn)].filter(({ values: all }) =>
      all.some((value) => value !== null),
    );
  }

  width() {
    return Math.max(240, this.container.clientWidth);
  }

  resize() {
    const width = this.width();
    for (const { plot } of this.charts) {
      if (plot.width !== width) plot.setSize({ width, height: plot.height });
    }
    this.seek(this.now);
  }

  /** Gives all charts the same range of time. */
  zoomed(plot) {
    if (this.isZooming) return;
    const { min, max } = plot.scales.x;
    this.isZooming = true;
    for (const other of this.charts) {
      if (other.plot !== plot) other.plot.setScale('x', { min, max });
    }
    this.isZooming = false;
    this.seek(this.now);
  }

  /** A click moves to its time; the line can be dragged, by finger from anywhere. */
  listen(plot) {
    const { over } = plot;
    const timeAt = (event) => {
      const { left } = over.getBoundingClientRect();
      const t = plot.posToVal(event.clientX - left, 'x');
      return Math.min(this.times.at(-1), Math.max(this.times[0], t));
    };
    const isNear = (event) => {
      const { left } = over.getBoundingClientRect();
      return Math.abs(event.clientX - left - plot.valToPos(this.now, 'x')) <= NEAR;
    };
    let [isDragged, from] = [false, 0];
    over.addEventListener('mousedown', (event) => isDragged && event.stopImmediatePropagation(), {
      capture: true,
    });
    over.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      from = event.clientX;
      isDragged = event.pointerType === 'touch' || isNear(event);
      if (!isDragged) return;
      over.setPointerCapture(event.pointerId);
      this.onSeek(timeAt(event));
    });
    over.addEventListener('pointermove', (event) => {
      if (isDragged) this.onSeek(timeAt(event));
      over.style.cursor = isNear(event) ? 'ew-resize' : '';
    });
    over.addEventListener('pointerup', (event) => {
      if (!isDragged && event.button === 0 && Math.abs(event.clientX - from) < 4) {
        this.onSeek(timeAt(event));
      }
      isDragged = false;
    });
    over.addEventListener('pointercancel', () => {
      isDragged = false;
    });
  }

  /** Moves the line, and updates the values next to the names. */
  seek(t) {
    this.now = t;
    for (const { plot, line, channels, values } of this.charts) {
      const { min, max } = plot.scales.x;
      line.hidden = !(t >= min && t <= max);
      line.style.transform = `translateX(${plot.valToPos(t, 'x').toFixed(2)}px)`;
      channels.forEach((channel, i) => {
        const value = this.valueAt(channel.values, t);
        const isZero = Math.abs(value) < ROUNDING * channel.largest;
        values[i].value.textContent = numberText(isZero ? 0 : value);
        const isShared = isWithin(channel.shared, t);
        values[i].remark.textContent = isShared ? 'not unique' : '';
      });
    }
  }

  /** Value of a curve at a time, interpolated between its points. */
  valueAt(values, t) {
    let [low, high] = [0, this.times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle;
      else high = middle;
    }
    const width = this.times[high] - this.times[low];
    const part = width > 0 ? Math.min(1, (t - this.times[low]) / width) : 0;
    return values[low] + part * (values[high] - values[low]);
  }
}

/** Size of the largest value of a curve. */
function largestOf(values) {
  let largest = 0;
  for (const value of values) {
    if (Number.isFinite(value)) largest = Math.max(largest, Math.abs(value));
  }
  return largest;
}

/** A unit as printed: `m/s²`, `N·m`. */
function printed(unit) {
  return unit.replaceAll('*', '·').replaceAll('^2', '²').replaceAll('^3', '³');
}

/** The curves at first: coordinates of one unit, and the energies. */
function overview(channels) {
  const states = channels.filter(({ name }) => name.startsWith('state.'));
  const unit = states[0]?.unit;
  const first = states.filter((channel) => channel.unit === unit).slice(0, 4);
  const energies = ['energy.kinetic', 'energy.potential', 'energy.total'];
  return [...first, ...channels.filter(({ name }) => energies.includes(name))];
}
