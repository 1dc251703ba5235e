/** Whether a joint is in the rotation tree and the translation tree. */

import type { ReactElement } from "react";
import { entryAt, entryOfPointer } from "../model/entries";
import { isInTree, saidOfTree, TREES, withTree, type TreeName } from "../model/trees";
import { edit, endGesture, useStore } from "../store";

export function TreeControl({ pointer }: { readonly pointer: string }): ReactElement {
  const id = entryOfPointer(pointer) ?? "";
  return <div className="trees-field">{TREES.map((name) => <TreeChoice key={name} id={id} name={name} pointer={pointer} />)}</div>;
}

const CHOICES = [["Automatic", null], ["Include", true], ["Exclude", false]] as const;

function TreeChoice({ id, name, pointer }: { readonly id: string; readonly name: TreeName; readonly pointer: string }): ReactElement {
  const data = useStore((state) => state.data);
  const summary = useStore((state) => state.check?.summary ?? null);
  const said = saidOfTree(entryAt(data, id)?.value["tree"], name);
  const now = isInTree(data, summary, id, name);
  const auto = said !== null || now === null ? "Automatic" : `Automatic (${now ? "in" : "out"})`;
  return (
    <div className="tree-choice">
      <span>{name === "rotation" ? "Rotation tree" : "Translation tree"}</span>
      <div className="segments" role="radiogroup" aria-label={`${name} tree`}>
        {CHOICES.map(([text, value]) => (
          <button
            key={text} type="button" role="radio" aria-checked={said === value} data-pointer={pointer}
            onClick={() => { endGesture(); edit((before) => withTree(before, id, name, value)); }}
          >{value === null ? auto : text}</button>
        ))}
      </div>
    </div>
  );
}
