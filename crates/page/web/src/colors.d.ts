/** A colour `[r, g, b, opacity]`, each 0 to 255, in CSS. */
export function css(color: number[], part?: number): string;
