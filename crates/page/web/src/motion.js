// The motion of the run: polynomials through values at Chebyshev points, one after the other.
//
//   τ_k = cos((2k + 1) π / (2d + 2)),  w_k = (−1)^k sin((2k + 1) π / (2d + 2)),  k = 0 … d
//   u(τ) = Σ w_k u_k / (τ − τ_k)  /  Σ w_k / (τ − τ_k)
//
// Berrut and Trefethen, Barycentric Lagrange Interpolation, SIAM Review 46 (2004), (4.2).

/** Bytes of base64 as an array of numbers of the given kind. */
export function decoded(base64, Kind) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Kind(bytes.buffer);
}

/** Points and weights of a degree. */
function chebyshev(degree) {
  const points = new Float64Array(degree + 1);
  const weights = new Float64Array(degree + 1);
  for (let k = 0; k <= degree; k += 1) {
    const angle = ((2 * k + 1) * Math.PI) / (2 * degree + 2);
    points[k] = Math.cos(angle);
    weights[k] = (k % 2 === 0 ? 1 : -1) * Math.sin(angle);
  }
  return { points, weights };
}

export class Motion {
  /** From the embedded data: times of the pieces, their degrees, and values, point by point. */
  constructor({ columns, axes, times, degrees, values }) {
    this.nColumns = columns;
    this.nAxes = axes;
    this.times = decoded(times, Float64Array);
    this.values = decoded(values, Float64Array);
    this.degrees = degrees;
    this.offsets = [0];
    for (const degree of degrees) {
      this.offsets.push(this.offsets.at(-1) + (degree + 1) * columns);
    }
    this.sharedRules = new Map();
  }

  get start() {
    return this.times[0];
  }

  get end() {
    return this.times.at(-1);
  }

  /** Index of the piece at `t`; at an event, the one after it. */
  pieceAt(t) {
    const forward = this.end < this.start ? -1 : 1;
    let [low, high] = [0, this.degrees.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if ((this.times[middle] - t) * forward <= 0) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  rule(degree) {
    if (!this.sharedRules.has(degree)) this.sharedRules.set(degree, chebyshev(degree));
    return this.sharedRules.get(degree);
  }

  /** Writes q, v and the forces of the joints at `t` into `out`. */
  at(t, out) {
    const piece = this.pieceAt(t);
    const [t0, t1] = [this.times[piece], this.times[piece + 1]];
    const half = 0.5 * (t1 - t0);
    const tau = half === 0 ? 0 : (t - 0.5 * (t0 + t1)) / half;
    const { points, weights } = this.rule(this.degrees[piece]);
    let whole = 0;
    out.fill(0);
    for (let k = 0; k < points.length; k += 1) {
      const first = this.offsets[piece] + k * this.nColumns;
      const distance = tau - points[k];
      if (distance === 0) {
        out.set(this.values.subarray(first, first + this.nColumns));
        return out;
      }
      const weight = weights[k] / distance;
      whole += weight;
      for (let i = 0; i < this.nColumns; i += 1) out[i] += weight * this.values[first + i];
    }
    for (let i = 0; i < this.nColumns; i += 1) out[i] /= whole;
    return out;
  }
}
