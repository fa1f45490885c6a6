/** World position of a point of a body, from 18 numbers for each body. */
export function positionOf(numbers: Float64Array, body: number, x: number, y: number, z: number): [number, number, number];
