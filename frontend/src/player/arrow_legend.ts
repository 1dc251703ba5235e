/** How long arrows are for how much: a bar of a round value, as on a map. */

import { formatQuantity, roundDown, VECTOR_COLORS, vectorGroup, type VectorGroup, type Viewer } from "../viewer";
import { create, setText } from "./dom";

const ROWS: readonly { group: VectorGroup; title: string }[] = [
  { group: "force", title: "force" },
  { group: "torque", title: "torque" },
  { group: "contact", title: "contact" },
  { group: "reaction", title: "reaction" },
];
const LONGEST = 90; // pixels
const SHARE = 0.15; // of the picture's width at most
const WIDEST_CURL = 40;

interface Row {
  readonly group: VectorGroup;
  readonly element: HTMLElement;
  readonly bar: HTMLElement;
  readonly text: HTMLElement;
  readonly kind: "force" | "torque";
}

export class ArrowLegend {
  readonly element = create("div", { class: "sb-arrows", role: "group", "aria-label": "Scale of arrows" });
  private readonly rows: Row[];

  constructor(private readonly viewer: Viewer) {
    const { vectors } = viewer.source;
    this.rows = ROWS.flatMap(({ group, title }) =>
      (["force", "torque"] as const)
        .filter((kind) => vectors.some((each) => each.kind === kind && vectorGroup(each) === group))
        .map((kind) => createRow(group, kind, group === "reaction" && kind === "torque" ? "reaction torque" : title)),
    );
    this.element.append(...this.rows.map((row) => row.element));
    this.element.hidden = this.rows.length === 0;
  }

  update(): void {
    for (const row of this.rows) {
      const metres = this.viewer.metresPer(row.kind);
      row.element.hidden = !this.viewer.shown[row.group] || metres === 0;
      if (row.element.hidden) continue;
      const pixels = metres * this.viewer.rig.pixelsPerMetre;
      const value = roundDown(Math.min(this.curled(row) ? WIDEST_CURL : LONGEST, SHARE * this.viewer.canvas.clientWidth) / pixels);
      row.bar.classList.toggle("sb-curl", this.curled(row));
      row.bar.style.width = `${(value * pixels).toFixed(1)}px`;
      setText(row.text, formatQuantity(value, row.kind === "force" ? "N" : "N\u202fm"));
    }
  }

  private curled(row: Row): boolean {
    return row.kind === "torque" && this.viewer.arrows.curled;
  }
}

function createRow(group: VectorGroup, kind: "force" | "torque", title: string): Row {
  const bar = create("span", { class: `sb-bar sb-bar-${kind}` });
  bar.style.setProperty("--sb-bar", VECTOR_COLORS[group]);
  const text = create("span", { class: "sb-number" });
  const element = create("div", { class: "sb-arrow-row" }, create("span", { class: "sb-bar-box" }, bar), text, create("span", {}, title));
  return { group, element, bar, text, kind };
}
