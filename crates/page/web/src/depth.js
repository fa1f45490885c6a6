// Depths in which shapes are painted in space, as in the other renderers, whose source says why:
// crates/scene/src/depth.rs.

/** Solids above which they are painted by their middles alone: pairs grow with the square. */
const MOST_SOLIDS = 100;
/** Normals of a solid that are tried at most: a mesh has thousands. */
const MOST_NORMALS = 100;
/** Shapes may overlap by this part of a pin's radius and count as apart. */
const OVERLAP = 0.3;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Smallest and largest position of a shape along a direction. */
function range({ points, radius }, n) {
  let [low, high] = [Infinity, -Infinity];
  for (const p of points) {
    const at = dot(n, p);
    low = Math.min(low, at);
    high = Math.max(high, at);
  }
  return [low - radius, high + radius];
}

/** Whether the first of two shapes is behind the second; `null` where neither hides the other or no plane tells. */
function isBehind(a, b, [right, up, eye], overlap) {
  const isApart = (n) => {
    const [[lowA, highA], [lowB, highB]] = [range(a, n), range(b, n)];
    return highA <= lowB || highB <= lowA;
  };
  if (isApart(right) || isApart(up)) return null;
  const between = a.middle.map((x, i) => b.middle[i] - x);
  const length = Math.hypot(...between);
  const tried = [...a.normals, ...b.normals.map((n) => n.map((x) => -x)), eye, eye.map((x) => -x)];
  if (length > 0) tried.push(between.map((x) => x / length));
  // The direction in which they are farthest apart, pointing from the first to the second.
  let best = [-Infinity, eye];
  for (const n of tried) {
    const gap = range(b, n)[0] - range(a, n)[1];
    if (gap > best[0]) best = [gap, n];
  }
  const towards = dot(best[1], eye);
  return best[0] >= -overlap && Math.abs(towards) > 1e-6 ? towards > 0 : null;
}

/** Raises the depths of shapes above those of the shapes that they hide. Each shape has its depth, its points in the
    world, a radius about them, and if it is a solid, its unit normals. */
export function sortSolids(shapes, rows, pin) {
  const nSolids = shapes.filter(({ isSolid }) => isSolid).length;
  if (nSolids === 0 || nSolids > MOST_SOLIDS) return;
  for (const shape of shapes) {
    shape.middle = [0, 1, 2].map((i) => shape.points.reduce((sum, p) => sum + p[i], 0) / (shape.points.length || 1));
    const step = Math.ceil(shape.normals.length / MOST_NORMALS);
    shape.normals = shape.normals.filter((_, k) => k % step === 0);
    [shape.hidden, shape.hides] = [[], 0];
  }
  shapes.forEach((a, i) => {
    for (const b of shapes.slice(i + 1)) {
      if (!(a.isSolid || b.isSolid)) continue;
      const behind = isBehind(a, b, rows, OVERLAP * pin);
      if (behind === null) continue;
      const [far, near] = behind ? [a, b] : [b, a];
      far.hidden.push(near);
      near.hides += 1;
    }
  });
  // From the back to the front; of a circle of shapes, that one first whose middle is farthest.
  const left = new Set(shapes);
  const farthest = (some) => some.reduce((first, shape) => (shape.depth < first.depth ? shape : first));
  while (left.size > 0) {
    const free = [...left].filter(({ hides }) => hides === 0);
    const next = farthest(free.length > 0 ? free : [...left]);
    left.delete(next);
    for (const near of next.hidden) {
      near.hides -= 1;
      if (left.has(near)) near.depth = Math.max(near.depth, next.depth + 1e-6 * pin);
    }
  }
}
