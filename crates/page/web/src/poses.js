// Poses of the bodies: a tape of operations from the state to 18 numbers for each body, which are
// its origin, the rows of its rotation, its velocity and its angular velocity, in world axes.

/** The functions of the operations. */
const OPERATIONS = {
  add: (a, b) => a + b,
  subtract: (a, b) => a - b,
  multiply: (a, b) => a * b,
  divide: (a, b) => a / b,
  negate: (a) => -a,
  power: (a, b) => a ** b,
  sin: Math.sin,
  cos: Math.cos,
  tan: Math.tan,
  asin: Math.asin,
  acos: Math.acos,
  atan: Math.atan,
  sinh: Math.sinh,
  cosh: Math.cosh,
  tanh: Math.tanh,
  exp: Math.exp,
  ln: Math.log,
  sqrt: Math.sqrt,
  abs: Math.abs,
  sign: Math.sign,
  atan2: (a, b) => Math.atan2(a, b),
  min: (a, b) => (a <= b || Number.isNaN(a) ? a : b),
  max: (a, b) => (a >= b || Number.isNaN(a) ? a : b),
  lt: (a, b) => (a < b ? 1 : 0),
  le: (a, b) => (a <= b ? 1 : 0),
  gt: (a, b) => (a > b ? 1 : 0),
  ge: (a, b) => (a >= b ? 1 : 0),
  if: (a, b, c) => (Number.isNaN(a) ? a : a === 0 ? c : b),
};

/** Count of numbers of a body. */
const NUMBERS = 18;

export class Poses {
  /** From the embedded tape. */
  constructor({ names, constants, parameters, inputs, code, prologue, outputs }) {
    this.operations = names.map((name) => OPERATIONS[name]);
    const first = constants.length + parameters.length;
    this.firstInput = first;
    this.firstResult = first + inputs;
    this.outputs = outputs;
    this.program = [];
    for (let at = 0; at < code.length; ) {
      const operation = this.operations[code[at]];
      const [a, b = 0, c = 0] = code.slice(at + 1, at + 1 + operation.length);
      this.program.push([operation, a, b, c]);
      at += 1 + operation.length;
    }
    this.nPrologue = prologue;
    this.registers = new Float64Array(this.firstResult + this.program.length);
    this.registers.set(constants.map(Number));
    this.registers.set(parameters, constants.length);
    // Operations on constants and parameters alone run once.
    this.run(0, prologue);
    this.numbers = new Float64Array(outputs.length);
  }

  run(from, to) {
    const registers = this.registers;
    for (let i = from; i < to; i += 1) {
      const [operation, a, b, c] = this.program[i];
      registers[this.firstResult + i] = operation(registers[a], registers[b], registers[c]);
    }
  }

  /** All numbers at the q and v that `state` begins with; the next call reuses the array. */
  at(state) {
    this.registers.set(state.subarray(0, this.firstResult - this.firstInput), this.firstInput);
    this.run(this.nPrologue, this.program.length);
    for (let i = 0; i < this.outputs.length; i += 1) {
      this.numbers[i] = this.registers[this.outputs[i]];
    }
    return this.numbers;
  }
}

/** World position of a point of a body. */
export function positionOf(numbers, body, x, y, z) {
  const at = NUMBERS * body;
  return [0, 1, 2].map((row) => {
    const first = at + 3 + 3 * row;
    return numbers[at + row] + numbers[first] * x + numbers[first + 1] * y + numbers[first + 2] * z;
  });
}

/** World velocity of a point of a body: that of the origin and ω × r. */
export function velocityOf(numbers, body, x, y, z) {
  const at = NUMBERS * body;
  const point = positionOf(numbers, body, x, y, z);
  const [rx, ry, rz] = [0, 1, 2].map((i) => point[i] - numbers[at + i]);
  const [vx, vy, vz, wx, wy, wz] = numbers.subarray(at + 12, at + 18);
  return [vx + wy * rz - wz * ry, vy + wz * rx - wx * rz, vz + wx * ry - wy * rx];
}
