/** Formulas that the server sent, as MathML. */

import { useEffect, useRef, type ReactElement } from "react";

const SPACE = "http://www.w3.org/1998/Math/MathML";
const ATTRIBUTES = new Set(["display", "mathvariant", "stretchy", "fence", "separator", "columnalign", "rowspacing", "columnspacing", "accent", "data-span", "width", "lspace", "rspace", "displaystyle", "scriptlevel", "minsize", "maxsize", "open", "close"]);

/** Return elements of a MathML text with nothing in them but mathematics. */
export function mathFrom(text: string): Element | null {
  const parsed = new DOMParser().parseFromString(text, "application/xml").documentElement;
  if (parsed.localName !== "math") return null;
  return cleaned(parsed);
}

function cleaned(element: Element): Element {
  const copy = document.createElementNS(SPACE, element.localName);
  for (const { name, value } of element.attributes) if (ATTRIBUTES.has(name)) copy.setAttribute(name, value);
  for (const child of element.childNodes) {
    if (child.nodeType === Node.TEXT_NODE) copy.append(child.textContent ?? "");
    else if (child instanceof Element && child.localName !== "annotation" && child.localName !== "annotation-xml") copy.append(cleaned(child));
  }
  return copy;
}

export function Formula({ text, block = false }: { text: string; block?: boolean }): ReactElement {
  const host = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    const element = mathFrom(text);
    if (block) element?.setAttribute("display", "block");
    host.current?.replaceChildren(...(element === null ? [] : [element]));
  }, [text, block]);
  return <span ref={host} className={block ? "formula block" : "formula"} />;
}
