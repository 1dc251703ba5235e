/** The picture of an example, asked for when its card comes into view. */

import { useEffect, useRef, useState, type ReactElement } from "react";
import { api } from "../api";
import { useShownTheme } from "../shell/theme";

interface Wish {
  readonly name: string;
  readonly dark: boolean;
  readonly take: (picture: string) => void;
}

const kept = new Map<string, string>();
let waiting: Wish[] = [];
let underWay: AbortController | null = null;

function keyOf({ name, dark }: Pick<Wish, "name" | "dark">): string {
  return `${name} ${String(dark)}`;
}

/** Ask for pictures one after the other: browsers open few connections, and a model that is opened must not wait for pictures. */
async function askInTurn(): Promise<void> {
  if (underWay !== null) return;
  const own = new AbortController();
  underWay = own;
  for (let wish = waiting.shift(); wish !== undefined && !own.signal.aborted; wish = waiting.shift()) {
    const { name, dark, take } = wish;
    try {
      const webp = await api.card(name, dark, own.signal);
      kept.set(keyOf(wish), webp && `data:image/webp;base64,${webp}`);
      take(kept.get(keyOf(wish))!);
    } catch {
      // a card without a picture has its words
    }
  }
  if (underWay === own) underWay = null;
}

/** Ask for a picture; return what takes the wish back. */
function want(wish: Wish): () => void {
  waiting.push(wish);
  void askInTurn();
  return () => { waiting = waiting.filter((each) => each !== wish); };
}

/** Ask for no more pictures: the cards are gone. */
export function forgetCards(): void {
  waiting = [];
  underWay?.abort();
  underWay = null;
}

/** Return the picture of an example once it is wanted; "" before, and where there is none. */
function useCard(name: string, dark: boolean, wanted: boolean): string {
  const key = keyOf({ name, dark });
  const [, redraw] = useState("");
  useEffect(() => (wanted && !kept.has(key) ? want({ name, dark, take: redraw }) : undefined), [name, dark, wanted, key]);
  return kept.get(key) ?? "";
}

export function CardPicture({ name }: { readonly name: string }): ReactElement {
  const place = useRef<HTMLDivElement>(null);
  const [seen, setSeen] = useState(false);
  const theme = useShownTheme();
  useEffect(() => {
    const watcher = new IntersectionObserver((entries) => { if (entries.some((each) => each.isIntersecting)) setSeen(true); });
    if (place.current !== null) watcher.observe(place.current);
    return () => { watcher.disconnect(); };
  }, []);
  const picture = useCard(name, theme !== "light", seen);
  return <div ref={place} className="card-picture">{picture !== "" && <img src={picture} alt="" />}</div>;
}
