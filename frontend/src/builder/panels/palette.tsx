/** All elements, to drag or to click, with a search. */

import { useMemo, useState, type DragEvent, type ReactElement } from "react";
import { forPalette, insertElement, joins, offered } from "../commands/insert";
import { DRAGGED } from "../diagram/gestures";
import { Icon } from "../shell/icons";
import { useRoving } from "../shell/roving";
import { useStore } from "../store";
import type { PaletteElement } from "../types";

/** Return the elements whose title, type or summary has all words of a search, best first. */
export function searched(elements: readonly PaletteElement[], text: string): PaletteElement[] {
  const words = text.toLowerCase().split(/\s+/).filter((each) => each !== "");
  const fits = elements.filter((each) => {
    const all = `${each.title} ${each.type} ${each.section} ${each.group} ${each.summary}`.toLowerCase();
    return words.every((word) => all.includes(word));
  });
  const first = words[0] ?? "";
  const rank = (each: PaletteElement): number => {
    const title = each.title.toLowerCase();
    return first === "" ? 0 : title.startsWith(first) ? 0 : title.includes(first) ? 1 : 2;
  };
  return fits.map((each, index) => ({ each, index })).sort((a, b) => rank(a.each) - rank(b.each) || a.index - b.index).map(({ each }) => each);
}

export function grouped(elements: readonly PaletteElement[]): [string, PaletteElement[]][] {
  const groups = new Map<string, PaletteElement[]>();
  for (const each of elements) groups.set(each.group, [...(groups.get(each.group) ?? []), each]);
  return [...groups];
}

export function Palette(): ReactElement {
  const schema = useStore((state) => state.schema);
  const [text, setText] = useState("");
  const roving = useRoving(".palette-item");
  const shown = useMemo(() => searched(schema === null ? [] : forPalette(offered(schema).filter((each) => each.section !== "ground")), text), [schema, text]);
  return (
    <div className="palette" data-testid="palette">
      <input
        type="search" className="search" placeholder="Search elements" aria-label="Search elements" value={text}
        onChange={(event) => { setText(event.target.value); }}
        onKeyDown={(event) => { if (event.key === "Enter" && shown[0] !== undefined) insertElement(shown[0].section, shown[0].type); }}
      />
      <div className="palette-list" {...roving}>
        {grouped(shown).map(([group, elements]) => (
          <section key={group} aria-label={group}>
            <h3>{group}</h3>
            <div className="palette-grid">{elements.map((each) => <PaletteItem key={`${each.section}/${each.type}`} element={each} />)}</div>
          </section>
        ))}
        {shown.length === 0 && <p className="soft pad">Nothing is called “{text}”.</p>}
      </div>
    </div>
  );
}

function PaletteItem({ element }: { readonly element: PaletteElement }): ReactElement {
  const drag = (event: DragEvent): void => {
    event.dataTransfer.setData(DRAGGED, `${element.section}/${element.type}`);
    event.dataTransfer.effectAllowed = "copy";
  };
  const how = joins(element) ? "Click to connect the selected bodies, or drag from port to port in the diagram." : "Click, or drag it into the diagram.";
  return (
    <button
      type="button" className="palette-item" draggable onDragStart={drag} title={`${element.summary} ${how}`}
      data-testid={`palette-${element.type === "" ? element.section : element.type}`} onClick={() => { insertElement(element.section, element.type); }}
    >
      <Icon name={element.type} fallback={element.section} size={17} />
      <span>{element.title}</span>
    </button>
  );
}
