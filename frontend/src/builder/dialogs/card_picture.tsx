/** The picture of an example, asked for when its card comes into view. */

import { useEffect, useRef, useState, type ReactElement } from "react";
import { api } from "../api";
import { useShownTheme } from "../shell/theme";

const kept = new Map<string, string>();

/** Return the picture of an example once it is wanted; "" before, and where there is none. */
function useCard(name: string, dark: boolean, wanted: boolean): string {
  const key = `${name} ${String(dark)}`;
  const [shown, setShown] = useState<readonly [string, string]>(["", ""]);
  useEffect(() => {
    if (!wanted || kept.has(key)) return;
    api.card(name, dark).then((png) => {
      kept.set(key, `data:image/png;base64,${png}`);
      setShown([key, kept.get(key)!]);
    }, () => undefined);
  }, [name, dark, wanted, key]);
  return kept.get(key) ?? (shown[0] === key ? shown[1] : "");
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
