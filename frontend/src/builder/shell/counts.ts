/** What was drawn and requested since the page was loaded: tests count it. */

export const counts: Record<string, number> = {};

export function count(what: string): void {
  counts[what] = (counts[what] ?? 0) + 1;
}
