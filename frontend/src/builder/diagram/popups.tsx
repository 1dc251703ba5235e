/** What opens at a place of the window: the choice of an element, and menus. */

import { useEffect, useLayoutEffect, useMemo, useRef, useState, type KeyboardEvent, type ReactElement, type ReactNode } from "react";
import { COMMANDS, giveCommand, printedKeys, type Command, type CommandName } from "../commands/all";
import { insertElement, joins, offered, usualFirst } from "../commands/insert";
import { GROUND } from "../model/entries";
import { grouped, searched } from "../panels/palette";
import { Icon } from "../shell/icons";
import { useStore } from "../store";
import type { PaletteElement } from "../types";

export function Popups(): ReactElement | null {
  const popup = useStore((state) => state.popup);
  if (popup === null) return null;
  if (popup.kind === "menu") return <Floating key="menu" x={popup.x} y={popup.y}><Menu target={popup.target} /></Floating>;
  return (
    <Floating key={popup.kind} x={popup.x} y={popup.y}>
      {popup.kind === "types"
        ? <Chooser title={`Join ${popup.ends[0]} and ${popup.ends[1]} by`} accepts={joins} order={usualFirst} choose={(each) => { insertElement(each.section, each.type, null, popup.ends); }} />
        : <Chooser title="Add" accepts={(each) => each.section !== GROUND} choose={(each) => { insertElement(each.section, each.type, popup.spot); }} />}
    </Floating>
  );
}

function stepOf(key: string): number {
  return key === "ArrowDown" ? 1 : key === "ArrowUp" ? -1 : 0;
}

function close(): void {
  useStore.setState({ popup: null });
}

/** A box at a place, moved so that all of it is seen; a press outside closes it. */
function Floating({ x, y, children }: { readonly x: number; readonly y: number; readonly children: ReactNode }): ReactElement {
  const box = useRef<HTMLDivElement>(null);
  const [place, setPlace] = useState({ left: x, top: y });
  useLayoutEffect(() => {
    const size = box.current?.getBoundingClientRect();
    if (size === undefined) return;
    setPlace({ left: Math.max(8, Math.min(x, window.innerWidth - size.width - 8)), top: Math.max(8, Math.min(y, window.innerHeight - size.height - 8)) });
  }, [x, y]);
  useEffect(() => {
    const before = document.activeElement;
    const press = (event: PointerEvent): void => {
      if (event.target instanceof Node && box.current?.contains(event.target) !== true) close();
    };
    document.addEventListener("pointerdown", press, true);
    return () => {
      document.removeEventListener("pointerdown", press, true);
      if (before instanceof HTMLElement && before.isConnected) before.focus({ preventScroll: true });
    };
  }, []);
  return <div ref={box} className="floating" style={place}>{children}</div>;
}

interface ChooserProps {
  readonly title: string;
  readonly accepts: (element: PaletteElement) => boolean;
  readonly order?: (elements: readonly PaletteElement[]) => readonly PaletteElement[];
  readonly choose: (element: PaletteElement) => void;
}

const asTheyAre = (elements: readonly PaletteElement[]): readonly PaletteElement[] => elements;

/** A search with a list under it: type, arrow keys, Enter. */
function Chooser({ title, accepts, order = asTheyAre, choose }: ChooserProps): ReactElement {
  const schema = useStore((state) => state.schema);
  const [text, setText] = useState("");
  const [place, setPlace] = useState(0);
  const list = useRef<HTMLDivElement>(null);
  const shown = useMemo(() => searched(schema === null ? [] : order(offered(schema).filter(accepts)), text), [schema, text, accepts, order]);
  const ordered = grouped(shown).flatMap(([, each]) => each);
  useEffect(() => { list.current?.querySelector('[aria-selected="true"]')?.scrollIntoView({ block: "nearest" }); }, [place]);
  const press = (event: KeyboardEvent): void => {
    event.stopPropagation();
    const step = stepOf(event.key);
    const chosen = ordered[place];
    if (step !== 0) {
      event.preventDefault();
      setPlace((place + step + ordered.length) % Math.max(1, ordered.length));
    } else if (event.key === "Escape") close();
    else if (event.key === "Enter" && chosen !== undefined) choose(chosen);
  };
  return (
    <div className="chooser" role="dialog" aria-label={title} data-testid="chooser">
      <input
        type="search" className="search" autoFocus value={text} placeholder={title} aria-label={title} role="combobox" aria-expanded="true"
        aria-controls="chooser-list" aria-activedescendant={`choice-${place}`} onKeyDown={press} onChange={(event) => { setText(event.target.value); setPlace(0); }}
      />
      <div ref={list} className="chooser-list" role="listbox" id="chooser-list" aria-label={title} tabIndex={-1}>
        {ordered.map((each, index) => <ChooserItem key={`${each.section}/${each.type}`} element={each} index={index} chosen={index === place} head={ordered[index - 1]?.group !== each.group} choose={choose} />)}
        {ordered.length === 0 && <p className="soft">Nothing is called “{text}”.</p>}
      </div>
    </div>
  );
}

function ChooserItem({ element, index, chosen, head, choose }: { readonly element: PaletteElement; readonly index: number; readonly chosen: boolean; readonly head: boolean; readonly choose: (element: PaletteElement) => void }): ReactElement {
  return (
    <>
      {head && <h3 role="presentation">{element.group}</h3>}
      <div role="option" id={`choice-${index}`} aria-selected={chosen} className="chooser-item" data-testid={`choose-${element.type === "" ? element.section : element.type}`} onClick={() => { choose(element); }}>
        <Icon name={element.type} fallback={element.section} size={17} />
        <span>{element.title}</span>
        <small>{element.summary}</small>
      </div>
    </>
  );
}

const ON_ENTRY: readonly (CommandName | null)[] = ["rename", "frame", null, "cut", "copy", "duplicate", "delete"];
const ON_CANVAS: readonly (CommandName | null)[] = ["insert", "paste", "selectAll", null, "arrange", "fit", null, "undo", "redo"];

function Menu({ target }: { readonly target: string | null }): ReactElement {
  const state = useStore.getState();
  const names = target === null ? ON_CANVAS : ON_ENTRY;
  return <MenuList label={target === null ? "Diagram" : "Element"} items={names.map((name) => (name === null ? null : menuItem(name, COMMANDS[name].title, state)))} />;
}

export interface MenuItem {
  readonly key: string;
  readonly text: string;
  readonly keys?: string;
  readonly disabled?: boolean;
  readonly run: () => void;
}

export function menuItem(name: CommandName, text: string, state = useStore.getState()): MenuItem {
  const command: Command = COMMANDS[name];
  const keys = command.keys[0];
  return {
    key: name, text, disabled: !(command.enabled?.(state) ?? true), run: () => { giveCommand(name); },
    ...(keys === undefined ? {} : { keys: printedKeys(keys) }),
  }; // prettier-ignore
}

/** A menu that arrow keys go through. */
export function MenuList({ label, items, done = close }: { readonly label: string; readonly items: readonly (MenuItem | null)[]; readonly done?: () => void }): ReactElement {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => { box.current?.querySelector<HTMLElement>("button:not(:disabled)")?.focus(); }, []);
  const press = (event: KeyboardEvent): void => {
    const step = stepOf(event.key);
    if (event.key === "Escape" || event.key === "Tab") done();
    if (step === 0 && event.key !== "Escape") return;
    const buttons = [...(box.current?.querySelectorAll<HTMLElement>("button:not(:disabled)") ?? [])];
    const at = buttons.indexOf(document.activeElement as HTMLElement);
    if (step !== 0) buttons[(at + step + buttons.length) % buttons.length]?.focus();
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div ref={box} className="menu" role="menu" aria-label={label} onKeyDown={press}>
      {items.map((item, index) => item === null
        ? <hr key={index} />
        : <button key={item.key} type="button" role="menuitem" disabled={item.disabled} onClick={() => { done(); item.run(); }}><span>{item.text}</span>{item.keys !== undefined && <kbd>{item.keys}</kbd>}</button>)}
    </div>
  );
}
