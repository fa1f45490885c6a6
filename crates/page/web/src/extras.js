// Additions to the mechanism: trails of chosen points, arrows of velocities and reactions.

import { ArrowScale } from './arrows.js';
import { isWithin } from './spans.js';
import { markerPosition, markerVelocity } from './scene.js';

/** Number of instants from which paths, sizes and extents are computed. */
const N_INSTANTS = 800;
/** Largest number of markers among which the one with the widest path is searched. */
const MAX_TRIED = 60;
/** Length of the longest arrow, relative to the mechanism's size. */
const ARROW = 0.22;

export class Extras {
  /** `run.at(t)` gives the numbers of all bodies at `t`, `run.forceAt(joint)` the force of a joint then. */
  /** `load` is the largest applied force of the run, N. */
  constructor(run, size, load) {
    this.run = run;
    this.load = load;
    this.size = size;
    this.trailed = new Set();
    this.hasNames = false;
    this.hasVelocities = false;
    this.hasReactions = false;
    this.paths = new Map();
    const { start, end } = run.motion;
    this.times = Float64Array.from(
      { length: N_INSTANTS + 1 },
      (_, k) => start + ((end - start) * k) / N_INSTANTS,
    );
  }

  /** The path of a marker over the run, computed once. */
  path(marker) {
    if (!this.paths.has(marker)) {
      const points = Array.from(this.times, (t) => markerPosition(this.run.at(t), marker));
      this.paths.set(marker, points);
    }
    return this.paths.get(marker);
  }

  /** Computes all that needs the whole run; the state of the run is at another instant afterwards. */
  prepare() {
    for (const marker of this.trailed) this.path(marker);
    if (this.hasVelocities) this.scaleOf('velocities');
    if (this.hasReactions) this.scaleOf('reactions');
  }

  /** The additions at `t`, where the bodies have `numbers`; after `prepare`. */
  at(t, numbers, theme) {
    const { colors } = theme;
    const nPast = this.times.findLastIndex((time) => (time - t) * (this.times[1] - this.times[0]) <= 0);
    const trails = [...this.trailed].map((marker, i) => {
      const points = [...this.path(marker)];
      // The trail reaches to the present position of the point.
      points.splice(nPast + 1, 0, markerPosition(numbers, marker));
      return { points, nPast: nPast + 2, color: colors.palette[(marker.at.body + i) % 6] };
    });
    const arrows = [];
    if (this.hasVelocities) {
      const scale = this.scaleOf('velocities');
      for (const marker of this.moving()) {
        const vector = scale.scaled(markerVelocity(numbers, marker));
        arrows.push({ from: markerPosition(numbers, marker), vector, color: colors.velocity });
      }
    }
    if (this.hasReactions) {
      const scale = this.scaleOf('reactions');
      for (const marker of this.joints()) {
        const vector = scale.scaled(this.run.forceAt(marker.joint));
        const isHollow = isWithin(marker.shared ?? [], t);
        arrows.push({ from: markerPosition(numbers, marker), vector, color: colors.force, isHollow });
      }
    }
    return { trails, arrows, hasNames: this.hasNames, legend: this.legend(theme) };
  }

  /** Markers whose velocities are shown: joints, centres of mass, and points with a trail. */
  moving() {
    const { markers } = this.run.scene;
    return markers.filter((marker) => marker.kind !== 'point' || this.trailed.has(marker));
  }

  /** The marker with the widest path, of points and centres of mass if there are any. */
  widest() {
    const moving = this.run.scene.markers.filter(({ at }) => at.body !== 0);
    const others = moving.filter(({ kind }) => kind !== 'joint');
    const candidates = (others.length > 0 ? others : moving).slice(0, MAX_TRIED);
    const width = (marker) => {
      const extents = [0, 1, 2].map((i) => {
        const values = this.path(marker).map((p) => p[i]).filter(Number.isFinite);
        return Math.max(...values) - Math.min(...values);
      });
      const [, middle, largest] = extents.sort((a, b) => a - b);
      return largest * (middle + 0.01 * largest);
    };
    const widths = candidates.map(width);
    return candidates[widths.indexOf(Math.max(...widths))];
  }

  joints() {
    return this.run.scene.markers.filter(({ kind }) => kind === 'joint');
  }

  /** The scale of arrows of velocities or reactions, over the whole run. */
  scaleOf(quantity) {
    this.scales ??= new Map();
    if (!this.scales.has(quantity)) {
      const peaks = [];
      for (let k = 0; k < this.times.length; k += 4) {
        const numbers = this.run.at(this.times[k]);
        const vectors =
          quantity === 'velocities'
            ? this.moving().map((marker) => markerVelocity(numbers, marker))
            : this.joints().map(({ joint }) => this.run.forceAt(joint));
        vectors.forEach((v, i) => {
          const size = Math.hypot(...v);
          if (Number.isFinite(size)) peaks[i] = Math.max(peaks[i] ?? 0, size);
        });
      }
      const reference = quantity === 'reactions' ? this.load : 0;
      this.scales.set(quantity, new ArrowScale(Object.values(peaks), ARROW * this.size, reference));
    }
    return this.scales.get(quantity);
  }

  /** The kinds of arrows that are shown, for their legend. */
  legend({ colors }) {
    const kinds = [];
    if (this.hasReactions) {
      kinds.push({ name: 'reaction', unit: 'N', color: colors.force, scale: this.scaleOf('reactions') });
    }
    if (this.hasVelocities) {
      kinds.push({ name: 'velocity', unit: 'm/s', color: colors.velocity, scale: this.scaleOf('velocities') });
    }
    return kinds;
  }
}
