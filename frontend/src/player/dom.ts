/** Elements of the page, made in one expression. */

type Child = Node | string;
type Attributes = Record<string, string | number | boolean>;

/** Return an element with attributes (false leaves one out) and children. */
export function create<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

export function createSvg(tag: string, attributes: Attributes = {}, ...children: Child[]): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

function setAttributes(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false) element.removeAttribute(name);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
}

/** Set the text of an element only where it differs, so that a still page stays still. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Offer a file to be saved. */
export function download(name: string, blob: Blob): void {
  const url = URL.createObjectURL(blob);
  const link = create("a", { href: url, download: name });
  link.click();
  setTimeout(() => { URL.revokeObjectURL(url); }, 1000);
}

/** Return a file name without what file systems refuse. */
export function fileName(title: string, ending: string): string {
  const stem = title.trim().replace(/[^\p{L}\p{N}._-]+/gu, "_").replace(/^_+|_+$/g, "");
  return `${stem === "" ? "symbody" : stem}${ending}`;
}
