/** Formulas that the server sent, as MathML. */

import { useEffect, useRef, type ReactElement } from "react";

const SPACE = "http://www.w3.org/1998/Math/MathML";
const ATTRIBUTES = new Set(["form", "display", "mathvariant", "stretchy", "fence", "separator", "columnalign", "rowspacing", "columnspacing", "accent", "data-span", "width", "lspace", "rspace", "displaystyle", "scriptlevel", "minsize", "maxsize", "open", "close"]);

/** What equations stand in: rows and terms between which lines are broken. */
const CLASSES = new Set(["sb-equations", "sb-equation", "sb-term", "sb-term sb-long", "sb-matrix", "sb-remark"]);

/** Return elements of a MathML text with nothing in them but mathematics. */
export function mathFrom(text: string): Element | null {
  const parsed = new DOMParser().parseFromString(text, "application/xml").documentElement;
  if (parsed.localName !== "math") return null;
  return cleaned(parsed);
}

/** Return equations, whose rows are HTML around mathematics, with nothing else in them. */
export function equationsFrom(text: string): readonly Element[] {
  const parsed = new DOMParser().parseFromString(`<div xmlns="http://www.w3.org/1999/xhtml">${text}</div>`, "application/xml").documentElement;
  return [...parsed.children].map(row);
}

function isWanted(name: string, value: string): boolean {
  return ["title", "data-span", "tabindex"].includes(name) || (name === "class" && CLASSES.has(value));
}

function row(element: Element): Element {
  if (element.localName === "math") return cleaned(element);
  const copy = document.createElement(element.localName === "div" ? "div" : "span");
  for (const { name, value } of element.attributes) if (isWanted(name, value)) copy.setAttribute(name, value);
  for (const child of element.childNodes) copy.append(child instanceof Element ? row(child) : child.textContent ?? "");
  return copy;
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

export function EquationRows({ text }: { text: string }): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => { host.current?.replaceChildren(...equationsFrom(text)); }, [text]);
  return <div ref={host} />;
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
