// The camera: the map from the world to pixels, without perspective.

/** Azimuth and elevation of the standard views, rad. */
export const VIEWS = {
  front: [0, 0],
  right: [Math.PI / 2, 0],
  top: [0, Math.PI / 2],
  isometric: [Math.PI / 4, Math.atan(Math.SQRT1_2)],
};

export class Camera {
  constructor(isPlanar) {
    this.centre = [0, 0, 0];
    this.scale = 1;
    this.size = [1, 1];
    this.reset(isPlanar);
  }

  /** The first view of a plane or spatial mechanism. */
  reset(isPlanar) {
    this.isPlanar = isPlanar;
    // A spatial mechanism is seen from the front, a little from the side and from above.
    this.azimuth = isPlanar ? 0 : 0.6;
    this.elevation = isPlanar ? 0 : 0.4;
    this.turn(0, 0);
  }

  /** Turns the view about the vertical axis and up or down, rad. */
  turn(about, up) {
    this.azimuth += about;
    this.elevation = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.elevation + up));
    const [sa, ca] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    // Rows: to the right, up, towards the eye.
    this.rows = this.isPlanar
      ? [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
      : [[ca, sa, 0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]];
  }

  /** Looks from a standard direction. */
  look(name) {
    [this.azimuth, this.elevation] = VIEWS[name];
    this.turn(0, 0);
  }

  /** A vector of the world as pixels to the right, pixels down, and metres towards the eye. */
  direction([x, y, z]) {
    const [right, up, near] = this.rows.map((row) => row[0] * x + row[1] * y + row[2] * z);
    return [this.scale * right, -this.scale * up, near];
  }

  /** A point of the world as pixels from the upper left corner. */
  project([x, y, z]) {
    const [cx, cy, cz] = this.centre;
    const [right, down, near] = this.direction([x - cx, y - cy, z - cz]);
    return [0.5 * this.size[0] + right, 0.5 * this.size[1] + down, near];
  }

  /** Moves the picture by pixels. */
  pan(dx, dy) {
    const [right, up] = this.rows;
    for (let i = 0; i < 3; i += 1) {
      this.centre[i] -= (dx * right[i] - dy * up[i]) / this.scale;
    }
  }

  /** Enlarges the picture about a pixel, which keeps its point. */
  zoom(factor, [x, y] = this.size.map((length) => 0.5 * length)) {
    const [dx, dy] = [x - 0.5 * this.size[0], y - 0.5 * this.size[1]];
    this.pan(-dx, -dy);
    this.scale *= factor;
    this.pan(dx, dy);
  }

  /** Fits all points into the picture, with a margin in pixels. */
  fit(points, margin) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const p of points) {
      if (!p.every(Number.isFinite)) continue;
      this.rows.forEach((row, axis) => {
        const x = row[0] * p[0] + row[1] * p[1] + row[2] * p[2];
        low[axis] = Math.min(low[axis], x);
        high[axis] = Math.max(high[axis], x);
      });
    }
    if (low[0] > high[0]) return;
    const scales = [0, 1].map((axis) => {
      const extent = Math.max(high[axis] - low[axis], 1e-9);
      return Math.max(this.size[axis] - 2 * margin, 20) / extent;
    });
    this.scale = Math.min(...scales);
    this.centre = [0, 1, 2].map((i) =>
      [0, 1, 2].reduce((sum, axis) => sum + 0.5 * (low[axis] + high[axis]) * this.rows[axis][i], 0),
    );
  }
}
