/** Panels whose sizes the user changes; the page remembers them. */

import { useEffect, useState, type CSSProperties, type KeyboardEvent, type PointerEvent, type ReactElement } from "react";

const KEY = "symbody-panels";

export interface Sizes {
  /** Widths of the sides [px]. */
  readonly left: number;
  readonly right: number;
  /** Share of the lower row in the height, and of the picture in its width. */
  readonly lower: number;
  readonly picture: number;
}

const USUAL: Sizes = { left: 270, right: 300, lower: 0.46, picture: 0.46 };
const LIMITS: Readonly<Record<keyof Sizes, readonly [number, number]>> = { left: [150, 420], right: [220, 560], lower: [0.15, 0.85], picture: [0.2, 0.8] };

function remembered(): Sizes {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "{}") as Partial<Sizes>;
    return { ...USUAL, ...kept };
  } catch {
    return USUAL;
  }
}

export function useSizes(): [Sizes, (name: keyof Sizes, value: number) => void, CSSProperties] {
  const [sizes, setSizes] = useState(remembered);
  useEffect(() => { localStorage.setItem(KEY, JSON.stringify(sizes)); }, [sizes]);
  const change = (name: keyof Sizes, value: number): void => {
    const [least, most] = LIMITS[name];
    setSizes((before) => ({ ...before, [name]: Math.min(most, Math.max(least, value)) }));
  };
  const style = { "--left": `${sizes.left}px`, "--right": `${sizes.right}px`, "--lower": `${(100 * sizes.lower).toFixed(2)}%`, "--picture": `${(100 * sizes.picture).toFixed(2)}%` } as CSSProperties;
  return [sizes, change, style];
}

interface SplitterProps {
  readonly name: keyof Sizes;
  readonly label: string;
  readonly upright: boolean;
  readonly sizes: Sizes;
  readonly change: (name: keyof Sizes, value: number) => void;
}

/** Return the size that a place of the pointer gives. */
function sizeAt(name: keyof Sizes, element: Element, x: number, y: number): number {
  const area = (name === "left" || name === "right" ? document.documentElement : element.parentElement!).getBoundingClientRect();
  if (name === "left") return x;
  if (name === "right") return area.right - x;
  return name === "lower" ? (area.bottom - y) / area.height : (x - area.left) / area.width;
}

export function Splitter({ name, label, upright, sizes, change }: SplitterProps): ReactElement {
  const share = sizes[name] <= 1;
  const [least, most] = LIMITS[name];
  const move = (event: PointerEvent): void => {
    if (event.currentTarget.hasPointerCapture(event.pointerId)) change(name, sizeAt(name, event.currentTarget, event.clientX, event.clientY));
  };
  const press = (event: KeyboardEvent): void => {
    const grows = name === "left" || name === "picture" ? ["ArrowRight", "ArrowLeft"] : upright ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    const step = event.key === grows[0] ? 1 : event.key === grows[1] ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    change(name, sizes[name] + step * (share ? 0.03 : 16));
  };
  return (
    <div
      className={`splitter ${upright ? "upright" : "level"} of-${name}`} role="separator" tabIndex={0} aria-label={label} aria-orientation={upright ? "vertical" : "horizontal"}
      aria-valuenow={Math.round(share ? 100 * sizes[name] : sizes[name])} aria-valuemin={Math.round(share ? 100 * least : least)} aria-valuemax={Math.round(share ? 100 * most : most)}
      onPointerDown={(event) => { event.currentTarget.setPointerCapture(event.pointerId); }} onPointerMove={move} onKeyDown={press}
    />
  );
}
