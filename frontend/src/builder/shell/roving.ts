/** One stop of the Tab key for a group of controls; arrow keys go through it. */

import { useEffect, useRef, type FocusEvent, type KeyboardEvent, type RefObject } from "react";

const STEPS: Readonly<Record<string, number>> = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

interface Roving {
  readonly ref: RefObject<HTMLDivElement | null>;
  readonly onKeyDown: (event: KeyboardEvent) => void;
  readonly onFocus: (event: FocusEvent) => void;
}

/** Return what makes an element such a group of all that a selector finds in it. */
export function useRoving(selector: string): Roving {
  const ref = useRef<HTMLDivElement>(null);
  const current = useRef<Element | null>(null);
  const items = (): HTMLElement[] => [...(ref.current?.querySelectorAll<HTMLElement>(selector) ?? [])].filter((each) => !each.matches(":disabled"));
  const mark = (): void => {
    const all = items();
    const stop = all.find((each) => each === current.current) ?? all.find((each) => each.getAttribute("aria-selected") === "true") ?? all[0];
    for (const each of all) each.tabIndex = each === stop ? 0 : -1;
  };
  useEffect(mark); // after each drawing: items come and go
  return {
    ref,
    onFocus: ({ target }) => {
      if (!target.matches(selector)) return;
      current.current = target;
      mark();
    },
    onKeyDown: (event) => {
      const all = items();
      const place = all.indexOf(event.target as HTMLElement);
      const ends: Readonly<Record<string, number>> = { Home: 0, End: all.length - 1 };
      const next = ends[event.key] ?? place + (STEPS[event.key] ?? 0);
      if (place < 0 || next === place || all[next] === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      all[next].focus();
    },
  };
}
