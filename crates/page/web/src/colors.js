// Colours as stylesheets write them.

/** A colour `[r, g, b, opacity]`, each 0 to 255, in CSS. */
export function css([r, g, b, opacity], part = 1) {
  return `rgb(${r} ${g} ${b} / ${((opacity / 255) * part).toFixed(3)})`;
}
