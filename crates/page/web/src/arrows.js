// The lengths of arrows: in proportion to sizes, or, where these differ by powers of ten, to their logarithms.

/** Ratio of the largest to the least vector from which lengths are logarithmic. */
const SPREAD = 200;
/** Powers of ten that a logarithmic scale has. */
const DECADES = 5;
/** Vectors below this part of the largest are rounding. */
const ROUNDING = 1e-9;
/** Forces and velocities below this are what rounding leaves of none at all. */
const NOTHING = 1e-18;

export class ArrowScale {
  /**
   * `peaks` are the largest sizes of each vector over the run; the largest of all has an arrow of `longest` metres. Those below
   * a part of `reference`, the largest size of this unit in the run, are rounding.
   */
  constructor(peaks, longest, reference = 0) {
    const floor = Math.max(NOTHING, ROUNDING * reference);
    this.largest = Math.max(0, ...peaks.filter((peak) => peak > floor));
    const least = Math.min(...peaks.filter((peak) => peak > ROUNDING * this.largest));
    this.longest = this.largest > 0 ? longest : 0;
    this.isLogarithmic = Number.isFinite(least) && this.largest > SPREAD * least;
  }

  /** The length of an arrow, m. */
  length(size) {
    const part = size / this.largest;
    if (!(part > ROUNDING && Number.isFinite(part))) return 0;
    return this.longest * Math.max(0, this.isLogarithmic ? 1 + Math.log10(part) / DECADES : part);
  }

  /** A vector as long as its arrow. */
  scaled(vector) {
    const size = Math.hypot(...vector);
    const perUnit = size > 0 ? this.length(size) / size : 0;
    return vector.map((x) => x * perUnit);
  }

  /** Round sizes whose arrows a legend shows, with their lengths, m. */
  samples() {
    if (this.longest === 0) return [];
    const power = 10 ** Math.floor(Math.log10(this.largest));
    const first = power * ([5, 2, 1].find((n) => n * power <= this.largest) ?? 1);
    const sizes = this.isLogarithmic ? [first, 0.01 * first] : [first];
    return sizes.map((size) => [size, this.length(size)]);
  }
}

/** A size with the prefix of its unit that leaves few digits: `50 kN`, `0.2 m/s`. */
export function quantityText(size, unit) {
  const prefixes = [[1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ']];
  const found = unit === 'N' ? prefixes.find(([factor]) => size >= 0.999 * factor) : undefined;
  const [factor, prefix] = found ?? [1, ''];
  return `${Number((size / factor).toPrecision(1))} ${prefix}${unit}`;
}
