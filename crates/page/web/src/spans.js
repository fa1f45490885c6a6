// Spans of time.

/** Whether a time is in one of the spans `[from, to]`, in rising order. */
export function isWithin(spans, t) {
  return spans.some(([from, to]) => from <= t && t <= to);
}
