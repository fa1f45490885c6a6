// Numbers as the page writes them.

/** A number of four significant digits. */
export function numberText(value) {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  const text =
    size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : value.toPrecision(4);
  return shortened(text);
}

/** Labels of the ticks of one axis, with the digits that show where they are: 2.5 is no 3. */
export function tickTexts(ticks) {
  const largest = Math.max(...ticks.map(Math.abs));
  const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : largest;
  const isLong = largest >= 1e5 || (largest < 1e-3 && largest > 0);
  const write = (x, digits) => (isLong ? x.toExponential(digits) : x.toFixed(digits));
  const isExact = (digits) =>
    ticks.every((x) => Math.abs(Number(write(x, digits)) - x) <= 1e-3 * step);
  const digits = [0, 1, 2, 3, 4, 5].find(isExact) ?? 6;
  return ticks.map((x) => (isLong && x === 0 ? '0' : shortened(write(x, digits))));
}

/** A number with a true minus sign and no plus in its exponent. */
function shortened(text) {
  return text.replace('e+', 'e').replaceAll('-', '−');
}
