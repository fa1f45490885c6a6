// The drawing: shapes on bodies, springs, dampers and links, trails, arrows and names.

import { quantityText } from './arrows.js';
import { css } from './colors.js';
import { cordLine } from './cords.js';
import { sortSolids } from './depth.js';
import { drawNames } from './names.js';
import { positionOf, velocityOf } from './poses.js';
import { cutShapes, half, height, pieces } from './section.js';
import { edgesOf, normalOf } from './solids.js';

// The direction to the light in the view: right, up, towards the eye.
const LIGHT = [-0.35, 0.55, 0.758];

/** The colour of a face that is turned away from the light by `shade`, 0 to 1. */
function shaded({ fill, stroke }, shade) {
  if (!stroke) return fill;
  const part = 0.6 * shade;
  return fill.map((x, i) => (i < 3 ? (1 - part) * x + part * stroke.color[i] : x));
}

export class Drawing {
  constructor(canvas, scene, camera) {
    this.context = canvas.getContext('2d');
    this.canvas = canvas;
    this.scene = scene;
    this.camera = camera;
    /** The section plane, by its axis, 0 to 2, and its distance from the origin, m; `null` if there is none. */
    this.section = null;
    for (const shape of scene.shapes) {
      if (shape.kind === 'solid') shape.edges = edgesOf(shape);
    }
    // Joints come before points, which are often at the same position.
    const ofKind = (name) => scene.markers.filter(({ kind }) => kind === name);
    this.named = [...ofKind('joint'), ...ofKind('point')];
    /** Outlines of bodies and springs in the plane, as they were last drawn. */
    this.areas = [];
    /** The places of names around their points that were taken last. */
    this.corners = new Map();
  }

  /** Fits the canvas to its size on the page, in the pixels of the screen. */
  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = globalThis.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.camera.size = [width, height];
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  /** Turns the signs of torques as these are at a time: a half turn about the line of each. */
  turnTo(t) {
    for (const turn of this.scene.turns ?? []) {
      const isOver = turn.times.filter((at) => at <= t).length % 2 === (turn.over ? 0 : 1);
      if (isOver === turn.drawnOver) continue;
      turn.drawnOver = isOver;
      const [from, along] = turn.line;
      for (const line of turn.shapes.flatMap((idx) => this.scene.shapes[idx].lines)) {
        for (let i = 0; i + 2 < line.length; i += 3) {
          const height = along.reduce((sum, a, k) => sum + a * (line[i + k] - from[k]), 0);
          for (const k of [0, 1, 2]) line[i + k] = 2 * (from[k] + height * along[k]) - line[i + k];
        }
      }
    }
  }

  /** Draws one instant; `extras` are trails and arrows, and whether names are shown. */
  draw(numbers, theme, extras) {
    const { context, camera } = this;
    const [width, height] = camera.size;
    context.fillStyle = css(theme.colors.background);
    context.fillRect(0, 0, width, height);
    context.lineJoin = 'round';
    context.lineCap = 'round';
    this.areas = [];
    this.half = this.section && half(this.section, camera.rows[2], this.scene.pin);
    for (const trail of extras.trails) this.drawTrail(trail);
    for (const draw of this.ordered(numbers, theme)) draw();
    for (const arrow of extras.arrows) if (this.isKept(arrow.from)) this.drawArrow(arrow);
    if (extras.hasNames) drawNames(this, numbers, theme);
    this.drawScale(theme);
    this.drawLegend(extras.legend ?? []);
  }

  /** Whether a point of the world lies in the half that is drawn. */
  isKept(p) {
    return !this.half || height(this.half, p) <= 0;
  }

  /** Functions that draw shapes and spans from back to front: in the scene's order, in space by depth. */
  ordered(numbers, theme) {
    const { planar, spans, cords, pin } = this.scene;
    const shapes = this.half ? cutShapes(this.scene.shapes, this.half, numbers) : this.scene.shapes;
    const near = (body, x, y, z) => this.camera.project(positionOf(numbers, body, x, y, z))[2];
    const depthOf = (shape) => {
      const line = shape.lines[0] ?? [];
      let sum = 0;
      for (let i = 0; i + 2 < line.length; i += 3) {
        sum += near(shape.frame ?? shape.body, line[i], line[i + 1], line[i + 2]);
      }
      return line.length === 0 ? 0 : (3 * sum) / line.length;
    };
    // Signs lie in front of their own middle, and of the whole rod or solid that they are on.
    const own = new Map(planar ? [] : shapes.map((shape) => [shape, depthOf(shape)]));
    const isFace = ({ kind }) => kind === 'section';
    if (!planar) this.sortSolids(own, numbers);
    // Cut faces lie in front of all that is left.
    const behind = [...own].filter(([shape]) => !shape.front && !isFace(shape)).map(([, depth]) => depth);
    const ends = this.half ? spans.flatMap(({ ends: pair }) => pair.map((at) => near(at.body, ...at.position))) : [];
    const face = [...behind, ...ends].reduce((most, depth) => Math.max(most, depth), -Infinity) + pin;
    for (const shape of shapes.filter(isFace)) own.set(shape, face);
    const rods = new Map();
    for (const [{ body, front, kind }, depth] of own) {
      if (['rod', 'solid', 'section'].includes(kind) && !front) rods.set(body, Math.max(depth, rods.get(body) ?? -Infinity));
    }
    const painted = (shape) =>
      shape.front
        ? Math.max(own.get(shape), rods.get(shape.body) ?? -Infinity) + pin
        : own.get(shape);
    const drawn = (shape) => [planar ? 0 : painted(shape), () => this.drawShape(shape, numbers, theme)];
    const spanned = (span) => [
      planar ? 0 : span.ends.reduce((sum, at) => sum + 0.5 * near(at.body, ...at.position), 0),
      () => this.drawSpan(span, numbers, theme),
    ];
    const layers = [
      ...shapes.filter(({ front }) => !front).map(drawn),
      ...spans.map(spanned),
      // Ropes and belts are in the plane alone.
      ...cords.map((cord) => [0, () => this.drawCord(cord, numbers, theme)]),
      ...shapes.filter(({ front }) => front).map(drawn),
    ];
    if (!planar) layers.sort(([a], [b]) => a - b);
    return layers.map(([, draw]) => draw);
  }

  /** Raises the depths of shapes above those of the shapes that they hide; signs and cut faces come later. */
  sortSolids(own, numbers) {
    const placed = [...own.keys()].filter(({ front, kind }) => !front && kind !== 'section').map((shape) => {
      const { frame = shape.body, lines, radius, kind, faces } = shape;
      const points = [];
      for (const line of lines) {
        for (let i = 0; i + 2 < line.length; i += 3) points.push(positionOf(numbers, frame, ...line.slice(i, i + 3)));
      }
      const isSolid = kind === 'solid';
      const normals = isSolid ? faces.map((face) => normalOf(face.map((corner) => points[corner]))) : [];
      return { shape, depth: own.get(shape), points, radius, normals, isSolid };
    });
    sortSolids(placed, this.camera.rows, this.scene.pin);
    for (const { shape, depth } of placed) own.set(shape, depth);
  }

  /** Fills and strokes the current path. */
  paint({ fill, stroke }, isArea) {
    const { context } = this;
    if (fill && isArea) {
      context.fillStyle = css(fill);
      context.fill('evenodd');
    }
    if (stroke) {
      context.strokeStyle = css(stroke.color);
      context.lineWidth = stroke.width;
      context.stroke();
    }
  }

  drawShape(shape, numbers, theme) {
    const { context, camera } = this;
    if (shape.kind === 'rod') {
      this.drawRod(shape, numbers, theme);
      return;
    }
    if (shape.kind === 'solid') {
      this.drawSolid(shape, numbers, theme);
      return;
    }
    if (shape.kind === 'section') {
      this.drawFace(shape, theme);
      return;
    }
    const { frame = shape.body } = shape;
    const path = new Path2D();
    for (const line of shape.lines) {
      for (let i = 0; i + 2 < line.length; i += 3) {
        const at = positionOf(numbers, frame, line[i], line[i + 1], line[i + 2]);
        const [x, y] = camera.project(at);
        if (i === 0) path.moveTo(x, y);
        else path.lineTo(x, y);
      }
      if (shape.kind !== 'line') path.closePath();
    }
    const { fill, stroke } = theme.paints[shape.role];
    if (fill && shape.kind === 'region') {
      context.fillStyle = css(fill);
      context.fill(path, 'evenodd');
      if (this.scene.planar) this.areas.push(path);
    }
    if (stroke) {
      context.strokeStyle = css(stroke.color);
      context.lineWidth = stroke.width;
      context.stroke(path);
    }
  }

  /** Draws the face of a solid at the section plane, hatched. */
  drawFace({ lines, hatching, role }, theme) {
    const { context, camera } = this;
    const { fill, outline, hatching: thin } = theme.sections[role];
    const outlines = new Path2D();
    for (const line of lines) {
      for (let i = 0; i + 2 < line.length; i += 3) {
        const [x, y] = camera.project(line.slice(i, i + 3));
        if (i === 0) outlines.moveTo(x, y);
        else outlines.lineTo(x, y);
      }
      outlines.closePath();
    }
    context.fillStyle = css(fill);
    context.fill(outlines, 'evenodd');
    context.beginPath();
    for (const [from, to] of hatching) {
      context.moveTo(...camera.project(from).slice(0, 2));
      context.lineTo(...camera.project(to).slice(0, 2));
    }
    context.strokeStyle = css(thin.color);
    context.lineWidth = thin.width;
    context.stroke();
    context.strokeStyle = css(outline.color);
    context.lineWidth = outline.width;
    context.stroke(outlines);
  }

  /** Draws a rod or ball: all points within its radius of the line between its projected ends. */
  drawRod(shape, numbers, theme) {
    const { context, camera } = this;
    const [line] = shape.lines;
    const end = (i) => camera.project(positionOf(numbers, shape.body, ...line.slice(i, i + 3)));
    const [[ax, ay], [bx, by]] = [end(0), end(3)];
    const radius = shape.radius * camera.scale;
    const angle = Math.atan2(by - ay, bx - ax);
    context.beginPath();
    context.arc(bx, by, radius, angle - Math.PI / 2, angle + Math.PI / 2);
    context.arc(ax, ay, radius, angle + Math.PI / 2, angle + 1.5 * Math.PI);
    context.closePath();
    const paint = theme.paints[shape.role];
    if (!paint.fill || line.slice(0, 3).some((x, i) => x !== line[i + 3])) {
      this.paint(paint, true);
      return;
    }
    // A ball is lit: the colour goes from where the light comes from to the edge that is across it.
    const [light, up] = LIGHT;
    const gradient = context.createRadialGradient(ax + radius * light, ay - radius * up, 0, ax, ay, radius);
    for (const part of [0, 0.25, 0.5, 0.75, 1]) {
      gradient.addColorStop(part, css(shaded(paint, part * part)));
    }
    context.fillStyle = gradient;
    context.fill();
    if (paint.stroke) {
      context.strokeStyle = css(paint.stroke.color);
      context.lineWidth = paint.stroke.width;
      context.stroke();
    }
  }

  /** Draws the faces of a solid that look towards the eye, the farthest first, each in a shade of its own. */
  drawSolid(shape, numbers, theme) {
    const { context, camera } = this;
    const [line] = shape.lines;
    const corners = [];
    for (let i = 0; i + 2 < line.length; i += 3) {
      // In the axes of the view, pixels: right, up, towards the eye.
      const [x, y, z] = camera.project(positionOf(numbers, shape.frame ?? shape.body, ...line.slice(i, i + 3)));
      corners.push([x, -y, z * camera.scale]);
    }
    const { fill, stroke } = theme.paints[shape.role];
    const faces = shape.faces.map((face) => {
      const ring = face.map((corner) => corners[corner]);
      const normal = normalOf(ring);
      const lit = LIGHT.reduce((sum, part, i) => sum + part * normal[i], 0);
      const depth = ring.reduce((sum, [, , z]) => sum + z, 0) / ring.length;
      return { ring, depth, shade: 1 - Math.min(1, Math.max(0, lit)), isSeen: normal[2] > 1e-9, place: -1, lines: [] };
    });
    const seen = faces.filter(({ isSeen }) => isSeen).sort((a, b) => a.depth - b.depth);
    // Sharp edges and the outline go with the nearer of their faces.
    seen.forEach((face, place) => {
      face.place = place;
    });
    for (const { corners: ends, faces: sides, isSharp } of shape.edges) {
      const [near, far] = sides.map((side) => faces[side]).sort((a, b) => b.place - a.place);
      if (near.isSeen && (isSharp || !far.isSeen)) near.lines.push(ends.map((end) => corners[end]));
    }
    const path = (points) => {
      context.beginPath();
      for (const [x, y] of points) context.lineTo(x, -y);
    };
    for (const { ring, shade, lines } of seen) {
      path(ring);
      context.closePath();
      context.fillStyle = css(shaded({ fill, stroke }, shade));
      context.fill();
      // A line of the same colour closes the gap that smooth edges leave to the next face.
      context.strokeStyle = context.fillStyle;
      context.lineWidth = 0.6;
      context.stroke();
      context.strokeStyle = css(stroke.color);
      context.lineWidth = stroke.width;
      for (const line of lines) {
        path(line);
        context.stroke();
      }
    }
  }

  /** Draws a spring, damper or link: interpolates its lines at the two lengths next to its own. */
  drawSpan(span, numbers, theme) {
    const { context, camera } = this;
    const ends = span.ends.map(({ body, position }) => positionOf(numbers, body, ...position));
    const along = ends[1].map((x, i) => x - ends[0][i]);
    const length = Math.hypot(...along);
    const axis = camera.direction(along);
    const [px, py] = camera.project(ends[0]);
    // Pixels of a metre along the span and across it.
    const [ux, uy] = length > 0 ? [axis[0] / length, axis[1] / length] : [camera.scale, 0];
    const pixels = Math.hypot(ux, uy) || 1;
    const [nx, ny] = [(uy / pixels) * camera.scale, (-ux / pixels) * camera.scale];
    if (this.scene.planar) {
      const [wide, high] = [nx, ny].map((x) => 2 * this.scene.pin * x);
      const [ex, ey] = [px + length * ux, py + length * uy];
      this.areas.push(new Path2D(`M${px + wide},${py + high}L${ex + wide},${ey + high}L${ex - wide},${ey - high}L${px - wide},${py - high}Z`));
    }
    // Height above the section plane of a point of the span, which lies in the plane of the view across its line.
    const [from, to] = ends.map((end) => (this.half ? height(this.half, end) : -1));
    const [right, up] = camera.rows.map((row) => (this.half ? row.reduce((sum, x, i) => sum + x * this.half.normal[i], 0) : 0));
    const aside = (nx * right - ny * up) / camera.scale;
    const heightAt = (x, y) => from + (length > 0 ? (x / length) * (to - from) : 0) + y * aside;
    const [low, high] = span.range;
    const n = span.lines.length - 1;
    const part = high > low ? Math.min(1, Math.max(0, (length - low) / (high - low))) * n : 0;
    const k = Math.min(n - 1, Math.floor(part));
    span.roles.forEach((role, at) => {
      const [short, long] = [span.lines[k][at], span.lines[k + 1][at]];
      if (short.length !== long.length) return;
      const points = [];
      for (let i = 0; i < short.length; i += 2) {
        const x = short[i] + (part - k) * (long[i] - short[i]);
        const y = short[i + 1] + (part - k) * (long[i + 1] - short[i + 1]);
        points.push([px + x * ux + y * nx, py + x * uy + y * ny, heightAt(x, y)]);
      }
      for (const piece of pieces(points)) {
        context.beginPath();
        for (const [x, y] of piece) context.lineTo(x, y);
        this.paint(theme.paints[role], false);
      }
    });
  }

  /** Draws a rope or belt around what it goes over now. */
  drawCord(cord, numbers, theme) {
    const { context, camera } = this;
    context.beginPath();
    for (const [x, y] of cordLine(cord, numbers)) context.lineTo(...camera.project([x, y, 0]).slice(0, 2));
    this.paint(theme.paints[cord.role], false);
  }

  /** Draws a path through the world; its future part is fainter. */
  drawTrail({ points, nPast, color }) {
    const { context, camera } = this;
    const line = (from, to, opacity) => {
      context.beginPath();
      const seen = points.slice(from, to).map((p) => [...camera.project(p).slice(0, 2), this.half ? height(this.half, p) : -1]);
      for (const piece of pieces(seen)) {
        piece.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
      }
      context.strokeStyle = css(color, opacity);
      context.lineWidth = 1.5;
      context.stroke();
    };
    line(0, points.length, 0.25);
    line(0, nPast, 0.9);
  }

  /** Draws an arrow: its tail and vector in the world, m; dashed and with an empty head where the vector is one of
      many solutions. */
  drawArrow({ from, vector, color, isHollow }) {
    const { context, camera } = this;
    const [x, y] = camera.project(from);
    const [dx, dy] = camera.direction(vector);
    const length = Math.hypot(dx, dy);
    if (!(length > 1)) return;
    const head = Math.min(9, 0.6 * length);
    const [ex, ey] = [dx / length, dy / length];
    context.strokeStyle = css(color);
    context.fillStyle = css(color);
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx - (isHollow ? 1 : 0.8) * head * ex, y + dy - (isHollow ? 1 : 0.8) * head * ey);
    context.setLineDash(isHollow ? [5, 4] : []);
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    context.moveTo(x + dx, y + dy);
    context.lineTo(x + dx - head * ex + 0.45 * head * ey, y + dy - head * ey - 0.45 * head * ex);
    context.lineTo(x + dx - head * ex - 0.45 * head * ey, y + dy - head * ey + 0.45 * head * ex);
    context.closePath();
    if (isHollow) context.stroke();
    else context.fill();
  }

  /** Draws a scale bar of a round length. */
  drawScale(theme) {
    const { context, camera } = this;
    const longest = 90 / camera.scale;
    const power = 10 ** Math.floor(Math.log10(longest));
    const length = power * ([5, 2, 1].find((n) => n * power <= longest) ?? 1);
    const pixels = length * camera.scale;
    const [x, y] = [14, camera.size[1] - 14];
    context.strokeStyle = css(theme.colors.faint);
    context.fillStyle = css(theme.colors.faint);
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y);
    context.lineTo(x + pixels, y);
    context.lineTo(x + pixels, y - 4);
    context.stroke();
    context.font = '12px system-ui, sans-serif';
    context.fillText(lengthText(length), x + 4, y - 6);
  }

  /** Draws an arrow of a round size for each kind of arrow, above the scale bar. */
  drawLegend(kinds) {
    const { context, camera } = this;
    let y = camera.size[1] - 44;
    context.font = '12px system-ui, sans-serif';
    for (const { name, unit, color, scale } of kinds) {
      for (const [size, metres] of scale.samples()) {
        const width = metres * camera.scale;
        const head = Math.min(10, width);
        context.strokeStyle = css(color);
        context.fillStyle = css(color);
        context.lineWidth = 2;
        context.beginPath();
        context.moveTo(14, y);
        context.lineTo(14 + width - head, y);
        context.stroke();
        context.beginPath();
        context.moveTo(14 + width, y);
        context.lineTo(14 + width - head, y - 0.35 * head);
        context.lineTo(14 + width - head, y + 0.35 * head);
        context.fill();
        context.fillText(`${name} ${quantityText(size, unit)}`, 14 + width + 8, y + 4);
        y -= 20;
      }
    }
  }
}

export function lengthText(metres) {
  if (metres >= 1000) return `${Number((metres / 1000).toPrecision(3))} km`;
  if (metres >= 1) return `${Number(metres.toPrecision(3))} m`;
  if (metres >= 0.01) return `${Number((metres * 100).toPrecision(3))} cm`;
  return `${Number((metres * 1000).toPrecision(3))} mm`;
}

/** Outermost points of the scene in the world at one instant. */
export function* outline(scene, numbers) {
  for (const shape of scene.shapes) {
    for (const line of shape.lines) {
      for (let i = 0; i + 2 < line.length; i += 3) {
        const [x, y, z] = positionOf(numbers, shape.body, line[i], line[i + 1], line[i + 2]);
        yield [x, y, z];
        for (const d of shape.radius > 0 ? [-shape.radius, shape.radius] : []) {
          yield* [[x + d, y, z], [x, y + d, z], [x, y, z + d]];
        }
      }
    }
  }
  for (const { ends } of scene.spans) {
    for (const { body, position } of ends) yield positionOf(numbers, body, ...position);
  }
  for (const { at, radius } of scene.cords.flatMap(({ places }) => places)) {
    const [x, y, z] = positionOf(numbers, at.body, ...at.position);
    for (const d of [-radius, radius]) yield* [[x + d, y, z], [x, y + d, z]];
  }
  for (const { at } of scene.markers) yield positionOf(numbers, at.body, ...at.position);
}

/** Velocity of a marker. */
export function markerVelocity(numbers, { at }) {
  return velocityOf(numbers, at.body, ...at.position);
}

/** World position of a marker. */
export function markerPosition(numbers, { at }) {
  return positionOf(numbers, at.body, ...at.position);
}
