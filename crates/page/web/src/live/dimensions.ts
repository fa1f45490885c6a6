// Distances of the points of each body, written at the picture and typed in place.

import { css } from '../colors.js';
import { positionOf } from '../poses.js';
import type { Stage } from './stage';
import type { Edit, Pixel, Point } from './types';

/** Pixels between the edge of a body and its dimension. */
const OFFSET = 14;
/** Half the width of a link over the radius of its pins. */
const HALF_WIDTH = 1.8;
/** More of them hide the mechanism. */
const MOST = 40;

interface Pair { from: Point; to: Point }

export class Dimensions {
  isOn = false;
  private labels: HTMLElement[] = [];
  private points: Point[] | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly holder: HTMLElement,
    private readonly edit: (edit: Edit) => void,
  ) {}

  show(isOn: boolean): void {
    this.isOn = isOn;
    this.points = null;
    this.holder.hidden = !isOn;
    this.stage.redraw();
  }

  /** Draws the lines of the dimensions, and puts their texts next to them. */
  paint(context: CanvasRenderingContext2D): void {
    const { stage } = this;
    if (!this.isOn || !stage.scene?.planar) return;
    const pairs = pairsOf(stage.points).slice(0, MOST);
    if (this.points !== stage.points) {
      this.points = stage.points;
      this.labels = pairs.map((pair) => this.label(pair));
      this.holder.replaceChildren(...this.labels);
    }
    context.strokeStyle = css(stage.scene.themes[stage.theme].colors.faint);
    context.lineWidth = 1;
    pairs.forEach((pair, k) => {
      const [a, b] = [pair.from, pair.to].map(({ body, at }) => stage.camera.project(positionOf(stage.numbers, body, ...at)) as unknown as Pixel);
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const offset = OFFSET + HALF_WIDTH * (stage.scene?.pin ?? 0) * stage.camera.scale;
      const normal = [(offset * (b[1] - a[1])) / length, (-offset * (b[0] - a[0])) / length];
      const ends = [a, b].map(([x, y]) => [x + normal[0], y + normal[1]]);
      context.beginPath();
      [a, ends[0], ends[1], b].forEach(([x, y]) => context.lineTo(x, y));
      context.stroke();
      const { style } = this.labels[k];
      style.left = `${(ends[0][0] + ends[1][0]) / 2}px`;
      style.top = `${(ends[0][1] + ends[1][1]) / 2}px`;
    });
  }

  /** A button that becomes a field when it is pressed. */
  private label({ from, to }: Pair): HTMLElement {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = lengthOf(from, to);
    button.title = `${from.name} – ${to.name}`;
    button.addEventListener('click', () => {
      const field = document.createElement('input');
      field.type = 'text';
      field.value = button.textContent ?? '';
      field.setAttribute('aria-label', button.title);
      button.replaceChildren(field);
      field.select();
      const leave = () => { button.textContent = lengthOf(from, to); };
      field.addEventListener('click', (event) => event.stopPropagation());
      field.addEventListener('blur', leave);
      field.addEventListener('keydown', (event) => {
        event.stopPropagation();
        if (event.key === 'Escape') leave();
        if (event.key !== 'Enter') return;
        const { value } = field;
        field.removeEventListener('blur', leave);
        leave();
        this.edit({ edit: 'length', from: from.name, to: to.name, value });
      });
    });
    return button;
  }
}

/** Neighbouring points of each body that are apart. */
function pairsOf(points: Point[]): Pair[] {
  return points.slice(1).flatMap((to, k) => {
    const from = points[k];
    const isPair = from.body === to.body && distance(from, to) > 0;
    return isPair ? [{ from, to }] : [];
  });
}

function distance({ at: a }: Point, { at: b }: Point): number {
  return Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
}

function lengthOf(from: Point, to: Point): string {
  return `${Number((1000 * distance(from, to)).toPrecision(6))} mm`;
}
