// Solids with plane faces: their normals and edges.

/** Unit normal of a plane ring; zero where it has no area. */
export function normalOf([origin, ...rest]) {
  const sum = [0, 0, 0];
  for (let i = 0; i + 1 < rest.length; i += 1) {
    const [a, b] = [rest[i], rest[i + 1]].map((p) => p.map((x, axis) => x - origin[axis]));
    for (let axis = 0; axis < 3; axis += 1) {
      const [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
      sum[axis] += a[j] * b[k] - a[k] * b[j];
    }
  }
  const length = Math.hypot(...sum) || 1;
  return sum.map((x) => x / length);
}

/** Faces whose normals are further apart than this (cosine) meet in an edge that is drawn from all sides. */
const SHARP = 0.9;

/** The edges of a solid: each with its corners, the faces on either side, and whether it is drawn from all sides. */
export function edgesOf({ lines: [line], faces }) {
  const corner = (i) => line.slice(3 * i, 3 * i + 3);
  const normals = faces.map((face) => normalOf(face.map(corner)));
  const open = new Map();
  const edges = [];
  faces.forEach((face, number) => {
    face.forEach((from, i) => {
      const to = face[(i + 1) % face.length];
      const other = open.get(`${to},${from}`);
      if (other === undefined) {
        open.set(`${from},${to}`, number);
        return;
      }
      open.delete(`${to},${from}`);
      const cosine = normals[number].reduce((sum, part, k) => sum + part * normals[other][k], 0);
      edges.push({ corners: [from, to], faces: [other, number], isSharp: cosine < SHARP });
    });
  });
  return edges;
}
