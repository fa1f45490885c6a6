/** The map from the world to pixels, without perspective. */
export class Camera {
  constructor(isPlanar: boolean);
  centre: number[];
  scale: number;
  size: number[];
  rows: number[][];
  isPlanar: boolean;
  reset(isPlanar: boolean): void;
  project(p: number[]): [number, number, number];
  pan(dx: number, dy: number): void;
  zoom(factor: number, at?: number[]): void;
  turn(about: number, up: number): void;
  fit(points: number[][], margin: number): void;
}
