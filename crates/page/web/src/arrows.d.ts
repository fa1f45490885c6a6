/** The lengths of arrows of vectors whose largest sizes are `peaks`, m. */
export class ArrowScale {
  constructor(peaks: number[], longest: number, reference?: number);
  length(size: number): number;
  scaled(vector: number[]): number[];
}
