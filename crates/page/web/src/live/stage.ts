// The picture under the hand: it is seen, held by mouse, finger or keys, and drawn on.

import { Camera } from '../camera.js';
import { css } from '../colors.js';
import { Drawing, lengthText, outline } from '../scene.js';
import type { Shown } from '../extras.js';
import { positionOf } from '../poses.js';
import { extent, snapped } from './geometry';
import { hit, worldAt, type Hit } from './picking';
import type { Tool } from './tool';
import type { Force, Joint, Pixel, Point, Scene, Shape, State, Theme, World } from './types';

const MARGIN = 48;
/** A motion is in the picture unless it is this many times as large as the mechanism. */
const FARTHEST = 3;
/** Pixels that an arrow key moves the cursor by, and with Shift. */
const KEY_STEPS = [4, 24];
/** A finger or button that moved less has clicked. */
const STILL = 4;

/** Force of an arrow, N for each metre that it is long. */
export const NEWTONS = 100;

export class Stage {
  readonly camera = new Camera(true);
  scene: Scene | null = null;
  points: Point[] = [];
  joints: Joint[] = [];
  forces: Force[] = [];
  numbers: Float64Array = new Float64Array(0);
  theme: 'light' | 'dark' = 'light';
  hasNames = true;
  /** Whether places that are drawn lie on a round grid; not while Alt is held. */
  isSnapping = true;
  /** The time of the motion that is shown; none of a pose. */
  t: number | null = null;
  /** Trails and arrows of what is shown. */
  extras: (t: number | null, numbers: Float64Array, theme: Theme) => Shown = () => ({ trails: [], arrows: [], hasNames: false, legend: [] });
  /** The part of a scene that is drawn while a body is cut free. */
  cut: (scene: Scene) => Scene | null = () => null;
  /** Poses of another motion, shown faintly. */
  ghost: Float64Array | null = null;
  /** Bodies that are lit, as a formula is pointed at. */
  lit: number[] = [];
  tool: Tool | null = null;
  /** Bodies that are selected, by name. */
  selected: string[] = [];
  /** True while Shift is held: what is pressed is selected, too. */
  isAdding = false;
  /** Is drawn over the picture. */
  over: ((context: CanvasRenderingContext2D) => void) | null = null;
  /** A place underneath near to another one, within a distance, m. */
  near: (world: World, reach: number) => World | null = () => null;
  /** Corners of what is underneath. */
  backdrop: () => number[][] = () => [];
  /** Points that the mechanism reaches while it moves. */
  motion: () => number[][] = () => [];
  private drawing: Drawing | null = null;
  private isFitted = true;
  private isInView = true;
  private isWaiting = false;
  private held: Hit | null = null;
  private hand: World | null = null;
  /** How far the hand is from the centre of the view towards the eye, m. */
  private depth = 0;
  private cursor: Pixel | null = null;
  /** The point that the keys went to last. */
  private nth = -1;
  private isKeyHeld = false;
  private pointers = new Map<number, Pixel>();
  private begin: Pixel = [0, 0];
  private isPanning = false;

  constructor(readonly canvas: HTMLCanvasElement, private readonly onView: () => void) {
    new ResizeObserver(() => this.resize()).observe(canvas);
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.moved(event));
    for (const end of ['pointerup', 'pointercancel'] as const) {
      canvas.addEventListener(end, (event) => this.up(event));
    }
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode === 1 ? 20 : 1)), this.pixelOf(event));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => this.key(event));
    canvas.addEventListener('blur', () => this.redraw());
  }

  /** Takes a new state; the picture is fitted again only where nothing was seen before. */
  take(state: State, numbers: Float64Array): void {
    if (!state.scene) return;
    const isFirst = !this.scene;
    this.joints = state.joints ?? [];
    this.points = state.points ?? [];
    this.forces = state.forces ?? [];
    this.setScene(state.scene);
    this.numbers = numbers;
    if (isFirst) this.fit();
    this.redraw();
  }

  setScene(scene: Scene): void {
    this.scene = scene;
    if (scene.planar !== this.camera.isPlanar) {
      this.camera.reset(scene.planar);
      this.isFitted = true;
    }
    this.drawing = new Drawing(this.canvas, scene, this.camera);
    this.drawing.resize();
  }

  /** Shows poses, those of a motion with the time. */
  pose(numbers: Float64Array, t: number | null = null): void {
    this.numbers = numbers;
    this.t = t;
    if (t !== null) this.drawing?.turnTo(t);
    this.redraw();
  }

  /** Fits the picture again, unless a hand has moved it. */
  refit(): void {
    if (this.isFitted) this.fit();
  }

  resize(): void {
    if (this.drawing) this.drawing.resize();
    else this.camera.size = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.refit();
    this.redraw();
  }

  /** Fits the picture where the mechanism was all in view, and no longer is. */
  bringIn(): void {
    const wasIn = this.isInView;
    this.isInView = this.isIn();
    if (wasIn && !this.isInView) this.fit();
  }

  private isIn(): boolean {
    const { scene, numbers, camera } = this;
    if (!scene || numbers.length < 18 * scene.bodies.length) return true;
    return [...outline(scene, numbers)].every((point) => camera.project(point).slice(0, 2).every((x, i) => x >= 0 && x <= camera.size[i]));
  }

  fit(): void {
    this.isFitted = true;
    const { scene, numbers, camera } = this;
    const points: number[][] = scene && numbers.length >= 18 ? [...outline(scene, numbers)] : [];
    points.push(...this.backdrop());
    // What flies away is not followed.
    const moved = this.motion();
    if (extent([...points, ...moved]) < FARTHEST * extent(points)) points.push(...moved);
    if (points.length > 1) {
      camera.fit(points, MARGIN);
    } else {
      // An empty plane is half a metre wide.
      camera.scale = camera.size[0] / 0.5;
      camera.centre = [0, 0, 0];
    }
    this.isInView = true;
    this.redraw();
    this.onView();
  }

  zoom(factor: number, at?: Pixel): void {
    this.isFitted = false;
    this.camera.zoom(factor, at);
    this.isInView = this.isIn();
    this.redraw();
  }

  redraw(): void {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.paint();
    });
  }

  /** How the mechanism is seen, for a picture that is drawn elsewhere. */
  get view(): object {
    const { centre, scale, rows, size } = this.camera;
    return { centre, scale, rows, size, is_dark: this.theme === 'dark', has_names: this.hasNames };
  }

  private paint(): void {
    const { drawing, scene, numbers, camera } = this;
    if (!drawing || !scene || numbers.length < 18 * scene.bodies.length) return;
    const theme: Theme = scene.themes[this.theme];
    const context = this.canvas.getContext('2d') as CanvasRenderingContext2D;
    const { trails, arrows, legend } = this.extras(this.t, numbers, theme);
    const cut = this.t === null ? null : this.cut(scene);
    const stated = cut ? [] : this.arrows(theme);
    const shown = cut ? new Drawing(this.canvas, cut, camera) : drawing;
    shown.draw(numbers, theme, { trails, arrows: [...stated, ...arrows], hasNames: this.hasNames, legend });
    if (cut) this.paintGhost(context, theme, numbers);
    else this.paintSizes(context, theme);
    this.over?.(context);
    if (this.ghost && this.ghost.length === numbers.length) this.paintGhost(context, theme, this.ghost);
    const accent = css(theme.colors.palette[0]);
    this.paintOutlines(context, numbers, ({ body }) => this.lit.includes(body), [accent, 3]);
    this.paintSelection(context, accent);
    const from = this.tool?.from;
    if (from && this.hand) {
      const way = [...(this.tool?.way?.slice(0, -1) ?? []), from, this.hand].map((p) => this.camera.project(p));
      context.strokeStyle = accent;
      context.lineWidth = 2;
      context.setLineDash([6, 4]);
      context.beginPath();
      for (const [x, y] of way) context.lineTo(x, y);
      context.stroke();
      context.setLineDash([]);
      const [a, b] = way.slice(-2);
      const length = Math.hypot(this.hand[0] - from[0], this.hand[1] - from[1]);
      context.fillStyle = css(theme.colors.text);
      context.font = '13px system-ui, sans-serif';
      if (length > 0) context.fillText(lengthText(length), (a[0] + b[0]) / 2 + 8, (a[1] + b[1]) / 2 - 8);
    }
    if (this.held && this.hand) {
      const at = positionOf(numbers, this.held.body, ...this.held.local);
      const [a, b] = [at, this.hand].map((p) => this.camera.project(p));
      context.strokeStyle = accent;
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
      context.stroke();
      context.beginPath();
      context.arc(a[0], a[1], 7, 0, 2 * Math.PI);
      context.stroke();
    }
    if (this.cursor && document.activeElement === this.canvas) this.paintCursor(context, accent);
  }

  /** Arrows of forces that stay as they are, as long as they are drawn unless that is out of all measure. */
  private arrows({ colors }: Theme): { from: number[]; vector: number[]; color: number[]; size: number }[] {
    const { numbers, camera } = this;
    return this.forces.flatMap(({ body, at, vector, follows }) => {
      const turned = follows ? [0, 1, 2].map((i) => [0, 1, 2].reduce((sum, j) => sum + numbers[18 * body + 3 + 3 * i + j] * vector[j], 0)) : vector;
      const size = Math.hypot(...turned);
      if (!(size > 0)) return [];
      const pixels = Math.min(120, Math.max(24, (size / NEWTONS) * camera.scale));
      return [{ from: positionOf(numbers, body, ...at), vector: turned.map((x) => (x * pixels) / (size * camera.scale)), color: colors.force, size }];
    });
  }

  /** Sizes of forces at the tips of their arrows. */
  private paintSizes(context: CanvasRenderingContext2D, theme: Theme): void {
    context.fillStyle = css(theme.colors.force);
    context.font = '13px system-ui, sans-serif';
    for (const { from, vector, size } of this.arrows(theme)) {
      const [x, y] = this.camera.project(from.map((p, i) => p + vector[i]) as World);
      context.fillText(`${Number(size.toPrecision(4))} N`, x + 6, y - 4);
    }
  }

  /** The outlines of all bodies in poses, faintly. */
  private paintGhost(context: CanvasRenderingContext2D, theme: Theme, poses: Float64Array): void {
    this.paintOutlines(context, poses, ({ body, front }) => body !== 0 && !front, [css(theme.colors.faint, 0.6), 1]);
  }

  private paintOutlines(context: CanvasRenderingContext2D, poses: Float64Array, isShown: (shape: Shape) => boolean, [colour, width]: [string, number]): void {
    const { scene, camera } = this;
    context.strokeStyle = colour;
    context.lineWidth = width;
    for (const shape of (scene as Scene).shapes.filter(isShown)) {
      for (const line of shape.lines) {
        context.beginPath();
        for (let i = 0; i + 2 < line.length; i += 3) {
          const [x, y] = camera.project(positionOf(poses, shape.body, line[i], line[i + 1], line[i + 2]));
          context.lineTo(x, y);
        }
        context.stroke();
      }
    }
  }

  private paintCursor(context: CanvasRenderingContext2D, color: string): void {
    const [x, y] = this.cursor as Pixel;
    context.strokeStyle = color;
    context.lineWidth = 1.5;
    context.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(x + 4 * dx, y + 4 * dy);
      context.lineTo(x + 12 * dx, y + 12 * dy);
    }
    context.stroke();
  }

  private pixelOf(event: { clientX: number; clientY: number }): Pixel {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  private at(pixel: Pixel, isTouch: boolean): { found: Hit | null; world: World } {
    const { scene, points, numbers, camera } = this;
    const found = scene && numbers.length > 0 ? hit(scene, points, numbers, camera, pixel, isTouch) : null;
    const world = worldAt(camera, pixel, this.depth);
    const isSnapped = this.isDrawing && this.isSnapping;
    return { found, world: isSnapped ? this.near(world, 10 / camera.scale) ?? snapped(world, this.grid) : world };
  }

  private get isDrawing(): boolean {
    return this.tool !== null && this.tool.name !== 'hand' && this.tool.name !== 'shape';
  }

  /** A round distance of eight pixels or more, m. */
  get grid(): number {
    const least = 8 / this.camera.scale;
    const decade = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((k) => k * decade).find((step) => step >= least * (1 - 1e-9)) ?? least;
  }

  /** The point or body under a pixel. */
  found(pixel: Pixel): Hit | null {
    return this.at(pixel, false).found;
  }

  /** Bodies of which a named point or joint is between two corners. */
  bodiesWithin(a: World, b: World): string[] {
    const { scene, numbers } = this;
    const isIn = (p: number[]) => [0, 1].every((i) => p[i] >= Math.min(a[i], b[i]) && p[i] <= Math.max(a[i], b[i]));
    const places = this.points.map(({ body, at }) => ({ body, p: positionOf(numbers, body, ...at) }));
    const found = new Set(places.filter(({ body, p }) => body !== 0 && isIn(p)).map(({ body }) => scene?.bodies[body] ?? ''));
    // A body with a point outside is not drawn around.
    for (const { body, p } of places) if (!isIn(p)) found.delete(scene?.bodies[body] ?? '');
    return [...found];
  }

  /** The band, and rings around the points of what is selected. */
  private paintSelection(context: CanvasRenderingContext2D, colour: string): void {
    const { camera, scene, numbers } = this;
    context.strokeStyle = colour;
    context.lineWidth = 2;
    for (const { body, at } of this.points) {
      if (!this.selected.includes(scene?.bodies[body] ?? '')) continue;
      const [x, y] = camera.project(positionOf(numbers, body, ...at));
      context.beginPath();
      context.arc(x, y, 9, 0, 2 * Math.PI);
      context.stroke();
    }
    const band = this.tool?.band?.map((corner) => camera.project(corner));
    if (!band) return;
    context.setLineDash([4, 4]);
    context.strokeRect(band[0][0], band[0][1], band[1][0] - band[0][0], band[1][1] - band[0][1]);
    context.setLineDash([]);
  }

  private down(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    const pixel = this.pixelOf(event);
    this.isSnapping = !event.altKey;
    this.pointers.set(event.pointerId, pixel);
    this.cursor = null;
    if (this.pointers.size > 1) {
      // Two fingers move the picture, not the mechanism.
      if (this.held || this.hand) this.tool?.cancel();
      this.held = null;
      this.isPanning = true;
      return;
    }
    this.begin = pixel;
    this.isAdding = event.shiftKey && this.tool?.name === 'select';
    this.press(pixel, event.pointerType === 'touch', event.button === 1 || (event.shiftKey && !this.isAdding));
  }

  private press(pixel: Pixel, isTouch: boolean, isView: boolean): void {
    const { found, world } = this.at(pixel, isTouch);
    const { isDrawing } = this;
    this.isPanning = isView || (!found && !isDrawing);
    if (this.isPanning) return;
    // The plane stays where it is drawn on.
    if (isDrawing) this.isFitted = false;
    this.depth = found ? this.camera.project(found.world)[2] : 0;
    this.hand = found ? (isDrawing ? found.world : worldAt(this.camera, pixel, this.depth)) : world;
    this.held = isDrawing ? null : found;
    this.tool?.press(found, this.hand);
    this.redraw();
  }

  private moved(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    const now = this.pixelOf(event);
    this.isSnapping = !event.altKey;
    if (!before) {
      if (this.tool?.from) {
        const { found, world } = this.at(now, false);
        this.hand = found?.names.length ? found.world : world;
        this.redraw();
      }
      return;
    }
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    this.pointers.set(event.pointerId, now);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const distance = (p: Pixel) => Math.max(1, Math.hypot(p[0] - other[0], p[1] - other[1]));
      this.isFitted = false;
      this.camera.pan(0.5 * dx, 0.5 * dy);
      this.camera.zoom(distance(now) / distance(before), [0.5 * (now[0] + other[0]), 0.5 * (now[1] + other[1])]);
      this.redraw();
    } else if (this.isPanning) {
      if (this.camera.isPlanar || event.shiftKey || event.buttons === 4) {
        this.isFitted = false;
        this.camera.pan(dx, dy);
      } else {
        this.camera.turn(-0.01 * dx, 0.01 * dy);
      }
      this.redraw();
    } else {
      this.hand = this.isDrawing ? this.at(now, false).world : worldAt(this.camera, now, this.depth);
      this.tool?.move(this.hand);
      this.redraw();
    }
  }

  private up(event: PointerEvent): void {
    const pixel = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (!pixel || this.pointers.size > 0) return;
    if (this.isPanning) this.isInView = this.isIn();
    else this.lift(pixel, event.pointerType === 'touch');
    this.isPanning = false;
  }

  private lift(pixel: Pixel, isTouch: boolean): void {
    const isClick = Math.hypot(pixel[0] - this.begin[0], pixel[1] - this.begin[1]) < STILL;
    const { found, world } = this.at(pixel, isTouch);
    const isDrawing = this.held === null;
    this.held = null;
    this.tool?.lift(isDrawing && found?.names.length ? found.world : world, isClick);
    if (!this.tool?.from) this.hand = null;
    this.redraw();
  }

  /** Keys: N goes to the next point, arrows move the cursor, Enter takes hold, lets go or clicks. */
  private key(event: KeyboardEvent): void {
    const arrows: Record<string, Pixel> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const arrow = arrows[event.key];
    const { camera } = this;
    const cursor = this.cursor ?? [0.5 * camera.size[0], 0.5 * camera.size[1]];
    if (arrow && this.tool?.nudge?.([arrow[0] * this.grid, -arrow[1] * this.grid])) {
      // The selection has moved, not the cursor.
    } else if (arrow) {
      const step = KEY_STEPS[event.shiftKey ? 1 : 0];
      this.cursor = [cursor[0] + step * arrow[0], cursor[1] + step * arrow[1]];
      this.hand = this.isKeyHeld || this.tool?.from ? worldAt(camera, this.cursor, this.depth) : null;
      if (this.isKeyHeld && this.hand) this.tool?.move(this.hand);
    } else if (event.key === 'n' || event.key === 'N') {
      this.cursor = this.nextPoint(cursor);
    } else if (event.key === 'Enter') {
      this.cursor = cursor;
      if (this.isKeyHeld) {
        this.isKeyHeld = false;
        this.lift(cursor, false);
      } else {
        this.begin = cursor;
        this.isAdding = event.shiftKey;
        this.press(cursor, false, false);
        this.isKeyHeld = this.held !== null;
        if (!this.isKeyHeld && !this.isPanning) this.lift(cursor, false);
        this.isPanning = false;
      }
    } else if (event.key === 'Escape') {
      this.isKeyHeld = false;
      this.held = null;
      this.hand = null;
      this.tool?.cancel();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
    this.redraw();
  }

  private nextPoint(cursor: Pixel): Pixel {
    const places: Pixel[] = [];
    for (const { body, at } of this.points) {
      const [x, y] = this.camera.project(positionOf(this.numbers, body, ...at));
      if (places.every((p) => Math.hypot(p[0] - x, p[1] - y) > 2)) places.push([x, y]);
    }
    this.nth = (this.nth + 1) % Math.max(1, places.length);
    return places[this.nth] ?? cursor;
  }
}
