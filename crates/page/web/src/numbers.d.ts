/** A number of four significant digits. */
export function numberText(value: number): string;
