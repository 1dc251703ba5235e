/** Puts the focus into the field that a problem, or a new row, points to. */

import { useEffect } from "react";
import { useStore } from "../store";

/** Return the control of a pointer, else that of the nearest place around or within it. */
export function controlOf(pointer: string): HTMLElement | null {
  const controls = [...document.querySelectorAll<HTMLElement>(".properties [data-pointer]")];
  const own = (each: HTMLElement): string => each.dataset["pointer"] ?? "";
  const exact = controls.find((each) => own(each) === pointer);
  if (exact !== undefined) return exact;
  const within = controls.find((each) => own(each).startsWith(`${pointer}/`));
  if (within !== undefined) return within;
  const around = controls.filter((each) => pointer.startsWith(`${own(each)}/`));
  return around.sort((a, b) => own(b).length - own(a).length)[0] ?? null;
}

/** Focus a control and bring it into view; its text is ready to be typed over. */
function focus(control: HTMLElement | null): void {
  control?.focus();
  control?.scrollIntoView({ block: "center" });
  if (control instanceof HTMLInputElement && control.type !== "checkbox") control.select();
  useStore.setState({ focusPointer: null });
}

export function useFocusPointer(): void {
  const pointer = useStore((state) => state.focusPointer);
  useEffect(() => {
    if (pointer === null) return undefined;
    const control = controlOf(pointer);
    if (control?.dataset["pointer"] === pointer) {
      focus(control);
      return undefined;
    }
    const before = document.activeElement;
    const wait = setTimeout(() => { // its panel may just be opening
      if (document.activeElement === before) focus(controlOf(pointer));
      else useStore.setState({ focusPointer: null }); // the user has gone elsewhere
    }, 30);
    return () => { clearTimeout(wait); };
  }, [pointer]);
}
