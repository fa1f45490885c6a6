// The section: what is left of shapes behind a plane, with the cut faces of solids. The same as in the other
// renderers, whose sources say why: crates/scene/src/section.rs.

import { positionOf } from './poses.js';
import { edgesOf } from './solids.js';

/** Height of the kept half above the plane, radii of a pin: rounding errors leave out nothing that lies in it. */
const SLACK = 1e-6;
/** Corners within this part of the largest height count as on the plane. */
const ON_PLANE = 1e-9;
/** Distance of the lines of a hatching, radii of a pin; lines over a face, fewest and most. */
const SPACING = 0.7;
const LINES = [4, 60];
/** Sides of a faceted rod, and rows of facets to either end. */
const SIDES = 32;
const ROWS = 8;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const sub = (a, b) => a.map((x, i) => x - b[i]);
const along = (a, factor, b) => a.map((x, i) => x + factor * b[i]);
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/** A unit vector across the unit vector `normal`, horizontal where that is told. */
function across(normal) {
  const horizontal = cross([0, 0, 1], normal);
  return unit(Math.hypot(...horizontal) > 1e-6 ? horizontal : cross([1, 0, 0], normal));
}

/** The half of space that is kept: the plane across an axis, less the side nearer to the eye. */
export function half({ axis, offset }, eye, pin) {
  const sign = eye[axis] < 0 ? -1 : 1;
  const normal = [0, 1, 2].map((i) => (i === axis ? sign : 0));
  const u = across(normal);
  const slack = SLACK * pin;
  const level = sign * offset + slack;
  return { normal, level, slack, u, v: cross(normal, u), hasFaces: dot(normal, eye) > 0, pin };
}

/** Height of a point above the plane: positive where it is left out. */
export const height = ({ normal, level }, p) => dot(normal, p) - level;

/** The pieces of a line that are kept; the last number of each point is its height. */
export function pieces(points) {
  const found = [];
  let last = null;
  for (const p of points) {
    const [before, now] = [last?.at(-1) ?? Infinity, p.at(-1)];
    if (now <= 0 !== before <= 0) {
      const crossing = last && along(last, before / (before - now), sub(p, last));
      if (now <= 0) found.push(crossing ? [crossing] : []);
      else found.at(-1).push(crossing);
    }
    if (now <= 0) found.at(-1).push(p);
    last = p;
  }
  return found;
}

/** Corners of areas, those on the plane after those that were given. */
class Cutter {
  constructor(plane, corners) {
    this.normal = plane.normal;
    this.corners = [...corners];
    this.heights = corners.map((p) => height(plane, p));
    const largest = this.heights.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
    this.heights = this.heights.map((x) => (Math.abs(x) <= ON_PLANE * largest ? 0 : x));
    this.crossings = new Map();
  }

  isKept(corner) {
    return this.heights[corner] <= 0;
  }

  /** The corner on the plane between two on different sides of it: the same one each time. */
  crossing(one, other) {
    const [a, b] = [Math.min(one, other), Math.max(one, other)];
    const key = `${a},${b}`;
    if (!this.crossings.has(key)) {
      const part = this.heights[a] / (this.heights[a] - this.heights[b]);
      this.crossings.set(key, this.corners.length);
      this.corners.push(along(this.corners[a], part, sub(this.corners[b], this.corners[a])));
    }
    return this.crossings.get(key);
  }

  /** The kept part of an area by its rings, and its edges on the plane, each with the number of its ring. */
  area(rings, normal) {
    const kept = { rings: [], cuts: [] };
    const chains = [];
    for (const ring of rings) {
      const out = ring.findIndex((corner) => !this.isKept(corner));
      if (out < 0) kept.rings.push(ring);
      else this.addChains([...ring.slice(out), ...ring.slice(0, out + 1)], chains);
    }
    // The ends of chains in their order along the plane; neighbours are joined.
    const direction = cross(normal, this.normal);
    const corner = ([chain, isTail]) => (isTail ? chains[chain].at(-1) : chains[chain][0]);
    const place = (end) => dot(direction, this.corners[corner(end)]);
    const ends = chains.flatMap((_, chain) => [[chain, 0], [chain, 1]]);
    const sorted = ends.map((end) => [place(end), end]).sort(([a], [b]) => a - b);
    const joined = chains.map(() => [null, null]);
    for (let i = 0; i + 1 < sorted.length; i += 2) {
      const [[, one], [, other]] = [sorted[i], sorted[i + 1]];
      joined[one[0]][one[1]] = other;
      joined[other[0]][other[1]] = one;
    }
    const used = new Set();
    for (let first = 0; first < chains.length; first += 1) {
      const ring = [];
      let [chain, isBackwards] = [first, 0];
      while (!used.has(chain)) {
        used.add(chain);
        ring.push(...(isBackwards ? [...chains[chain]].reverse() : chains[chain]));
        const end = [chain, isBackwards ? 0 : 1];
        const next = joined[end[0]][end[1]];
        kept.cuts.push([[corner(end), corner(next)], kept.rings.length]);
        [chain, isBackwards] = next;
      }
      if (ring.length > 0) kept.rings.push(ring);
    }
    return kept;
  }

  /** Adds the kept chains of a ring that begins and ends with the same corner, which is left out. */
  addChains(ring, chains) {
    for (let i = 1; i < ring.length; i += 1) {
      const [before, now] = [ring[i - 1], ring[i]];
      const [was, is] = [before, now].map((corner) => this.isKept(corner));
      if (is && !was) chains.push([this.crossing(before, now)]);
      if (is) chains.at(-1).push(now);
      else if (was) chains.at(-1).push(this.crossing(before, now));
    }
  }
}

/** Twice the area of a ring as a vector. */
function areaOf([origin, ...rest]) {
  let sum = [0, 0, 0];
  for (let i = 0; i + 1 < rest.length; i += 1) {
    sum = along(sum, 1, cross(sub(rest[i], origin), sub(rest[i + 1], origin)));
  }
  return sum;
}

/** Segments between corners joined to rings; what does not close is left out. */
function ringsOf(segments) {
  const at = new Map();
  segments.forEach((segment, number) => {
    for (const corner of segment) at.set(corner, [...(at.get(corner) ?? []), number]);
  });
  const used = new Set();
  const rings = [];
  segments.forEach(([first, second], number) => {
    if (used.has(number)) return;
    used.add(number);
    const ring = [first];
    let corner = second;
    while (corner !== first) {
      ring.push(corner);
      const next = at.get(corner).find((other) => !used.has(other));
      if (next === undefined) return;
      used.add(next);
      const [a, b] = segments[next];
      corner = a === corner ? b : a;
    }
    if (ring.length > 2) rings.push(ring);
  });
  return rings;
}

/** What is left of a solid, as corners, faces and edges, and the rings about its cut face; `null` if nothing is. */
function cutSolid(plane, { corners, faces, edges }) {
  const cutter = new Cutter(plane, corners);
  if (cutter.heights.every((x) => x <= 0)) return { corners, faces, edges, rings: [] };
  if (!cutter.heights.some((x) => x < -2 * plane.slack)) return null;
  const left = { faces: [], edges: [] };
  const cuts = [];
  const pieces = faces.map((face) => {
    const first = left.faces.length;
    const { rings, cuts: own } = cutter.area([face], areaOf(face.map((corner) => corners[corner])));
    left.faces.push(...rings);
    cuts.push(...own.map(([cut, ring]) => [cut, first + ring]));
    return [first, left.faces.length];
  });
  for (const { corners: [a, b], faces: sides, isSharp } of edges) {
    const [from, to] = cutter.isKept(a) ? [a, b] : [b, a];
    if (!cutter.isKept(from)) continue;
    const ends = [from, cutter.isKept(to) ? to : cutter.crossing(a, b)];
    const piece = ([first, end]) => {
      for (let k = first; k < end; k += 1) if (left.faces[k].includes(from)) return k;
      return -1;
    };
    const own = sides.map((side) => piece(pieces[side]));
    if (own.every((face) => face >= 0)) left.edges.push({ corners: ends, faces: own, isSharp });
  }
  // The edges of the cut are drawn with the one face that they have.
  for (const [cut, face] of cuts) left.edges.push({ corners: cut, faces: [face, face], isSharp: true });
  const rings = ringsOf(cuts.map(([cut]) => cut)).map((ring) => ring.map((corner) => cutter.corners[corner]));
  return { corners: cutter.corners, ...left, rings };
}

/** A rod or ball as a solid whose corners lie on it. */
function faceted([from, to], radius) {
  const isBall = Math.hypot(...sub(to, from)) === 0;
  const axis = isBall ? [0, 0, 1] : unit(sub(to, from));
  const u = across(axis);
  const v = cross(axis, u);
  const rows = [...Array(ROWS).keys()].map((row) => (0.5 * Math.PI * row) / ROWS);
  const circles = [...rows.map((angle) => [from, -angle]).reverse(), ...rows.slice(isBall ? 1 : 0).map((angle) => [to, angle])];
  const corners = [along(from, -radius, axis)];
  for (const [centre, latitude] of circles) {
    const middle = along(centre, radius * Math.sin(latitude), axis);
    for (let side = 0; side < SIDES; side += 1) {
      const angle = (2 * Math.PI * side) / SIDES;
      const arm = radius * Math.cos(latitude);
      corners.push(along(along(middle, arm * Math.cos(angle), u), arm * Math.sin(angle), v));
    }
  }
  corners.push(along(to, radius, axis));
  const corner = (circle, side) => 1 + circle * SIDES + (side % SIDES);
  const last = circles.length - 1;
  const faces = [];
  for (let side = 0; side < SIDES; side += 1) {
    faces.push([0, corner(0, side + 1), corner(0, side)]);
    for (let k = 1; k <= last; k += 1) {
      faces.push([corner(k - 1, side), corner(k - 1, side + 1), corner(k, side + 1), corner(k, side)]);
    }
    faces.push([corner(last, side), corner(last, side + 1), corners.length - 1]);
  }
  return { corners, faces, edges: edgesOf({ lines: [corners.flat()], faces }) };
}

/** The lines of the hatching of a body's cut face, inside its rings. */
function hatching(rings, { u, v, pin }, body) {
  const angle = ((body % 2 === 0 ? 45 : 135) * Math.PI) / 180;
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const flat = rings.map((ring) =>
    ring.map((p) => {
      const [x, y] = [dot(p, u), dot(p, v)];
      return [x * cos + y * sin, y * cos - x * sin];
    }),
  );
  const heights = flat.flat().map(([, y]) => y);
  const [low, high] = heights.reduce(([a, b], y) => [Math.min(a, y), Math.max(b, y)], [Infinity, -Infinity]);
  const usual = SPACING * [1, 1.5, 0.75][Math.floor(body / 2) % 3] * pin;
  const [fewest, most] = LINES.map((lines) => Math.log2((high - low) / usual / lines));
  const spacing = usual * 2 ** Math.max(Math.ceil(most), Math.min(0, Math.max(-3, Math.floor(fewest))));
  if (!(spacing > 0 && Number.isFinite(high - low))) return [];
  const crossings = [];
  for (const ring of flat) {
    ring.forEach(([x, y], i) => {
      const [nextX, nextY] = ring[(i + 1) % ring.length];
      const end = Math.ceil(Math.max(y, nextY) / spacing);
      for (let line = Math.ceil(Math.min(y, nextY) / spacing); line < end; line += 1) {
        crossings.push([line, x + ((line * spacing - y) / (nextY - y)) * (nextX - x)]);
      }
    });
  }
  crossings.sort(([a, x], [b, y]) => a - b || x - y);
  const level = rings[0][0];
  const raised = ([line, x]) => {
    const y = line * spacing;
    const [p, q] = [x * cos - y * sin, x * sin + y * cos];
    return along(along(level, p - dot(level, u), u), q - dot(level, v), v);
  };
  const lines = [];
  for (let i = 0; i + 1 < crossings.length; i += 2) lines.push([raised(crossings[i]), raised(crossings[i + 1])]);
  return lines;
}

/** The points of a flat list of coordinates in the world. */
function placed(line, body, numbers) {
  const points = [];
  for (let i = 0; i + 2 < line.length; i += 3) points.push(positionOf(numbers, body, line[i], line[i + 1], line[i + 2]));
  return points;
}

/** The shapes that are left of a shape, in the world. */
function cutShape(shape, plane, numbers) {
  const lines = shape.lines.map((line) => placed(line, shape.body, numbers));
  // In the frame of the ground, which is the world.
  const left = (kind, points, more) => ({ ...shape, frame: 0, kind, lines: points.map((line) => line.flat()), ...more });
  const all = lines.flat();
  if (shape.front && !shape.isCurve) {
    const middle = all.reduce((sum, p) => sum + height(plane, p), 0) / all.length;
    return middle <= 0 ? [shape] : [];
  }
  const solid = (whole) => {
    const cut = cutSolid(plane, whole);
    if (!cut) return [];
    const { corners, faces, edges, rings } = cut;
    const body = left('solid', [corners], { faces, edges });
    if (!plane.hasFaces || rings.length === 0) return [body];
    return [body, left('section', rings, { hatching: hatching(rings, plane, shape.body) })];
  };
  switch (shape.kind) {
    case 'rod': {
      const heights = all.map((p) => height(plane, p));
      if (Math.max(...heights) <= -shape.radius) return [shape];
      return Math.min(...heights) < shape.radius ? solid(faceted(all, shape.radius)) : [];
    }
    case 'solid':
      return solid({ corners: all, faces: shape.faces, edges: shape.edges });
    case 'region': {
      const cutter = new Cutter(plane, all);
      let first = 0;
      const rings = lines.map((line) => {
        first += line.length;
        return line.map((_, i) => first - line.length + i);
      });
      const normals = lines.map(areaOf).sort((a, b) => dot(b, b) - dot(a, a));
      const area = cutter.area(rings, normals[0] ?? [0, 0, 0]);
      return area.rings.length > 0 ? [left('region', area.rings.map((ring) => ring.map((corner) => cutter.corners[corner])))] : [];
    }
    default: {
      const [line = []] = lines;
      const measured = line.map((p) => [...p, height(plane, p)]);
      if (measured.every((p) => p[3] <= 0)) return [shape];
      const out = shape.kind === 'ring' ? measured.findIndex((p) => p[3] > 0) : -1;
      const turned = out < 0 ? measured : [...measured.slice(out), ...measured.slice(0, out + 1)];
      return pieces(turned).map((piece) => left('line', [piece.map((p) => p.slice(0, 3))]));
    }
  }
}

/** The shapes that are left in a half of space. */
export function cutShapes(shapes, plane, numbers) {
  return shapes.flatMap((shape) => cutShape(shape, plane, numbers));
}
