/** A panel that a button opens; Escape, the button or a click elsewhere closes it. */

import { create } from "./dom";
import { iconButton, type IconName } from "./icons";

let made = 0;

export class Popover {
  readonly panel: HTMLElement;
  readonly button: HTMLButtonElement;

  constructor(name: IconName, label: string, ...content: Node[]) {
    made += 1;
    const id = `sb-panel-${made}`;
    this.panel = create("div", { class: "sb-panel", id, role: "group", "aria-label": label }, ...content);
    this.panel.hidden = true;
    this.button = iconButton(name, label, "", () => { this.toggle(!this.open); });
    this.button.setAttribute("aria-expanded", "false");
    this.button.setAttribute("aria-controls", id);
  }

  get open(): boolean {
    return !this.panel.hidden;
  }

  toggle(open: boolean): void {
    if (open === this.open) return;
    const focused = this.panel.matches(":focus-within"); // what is hidden has no focus
    this.panel.hidden = !open;
    this.button.setAttribute("aria-expanded", String(open));
    if (!open && focused) this.button.focus();
  }

  /** Close if a press is neither in the panel nor on the button. */
  closeFor(path: readonly EventTarget[]): void {
    if (!path.includes(this.panel) && !path.includes(this.button)) this.toggle(false);
  }
}
