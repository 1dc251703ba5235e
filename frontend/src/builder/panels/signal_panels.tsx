/** What inputs and parts show on the right side, and who reads what is selected. */

import { useMemo, type ReactElement } from "react";
import { showNode } from "../diagram/flow";
import { entryAt, textOf, type Entry, type EntryId } from "../model/entries";
import { labelOf } from "../model/fields";
import { isArray, isObject } from "../model/pointers";
import { wiresOf } from "../model/wires";
import { acceptName } from "../rename_command";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import type { Json } from "../types";
import { FieldFrame, useProblems } from "./field_frame";
import { NameInput } from "./inputs";

export function InputPanel({ id, entry, buttons }: { readonly id: EntryId; readonly entry: Entry; readonly buttons: ReactElement }): ReactElement {
  return (
    <div className="pad form">
      <header className="form-head"><Icon name="inputs" size={20} /><h2>{entry.name}</h2><span className="soft">Input</span></header>
      <p className="tip">Given from outside during the motion: a number, or a formula in t set in the simulation dialog.</p>
      <FieldFrame label="Name" tip="Appears in formulas." problems={useProblems(`/${id}`)}>
        {(field, describedBy) => <NameInput pointer={`/${id}`} id={field} describedBy={describedBy} value={entry.name} change={(text) => acceptName(id, text)} />}
      </FieldFrame>
      <Readers id={id} />
      {buttons}
    </div>
  );
}

function textOfValue(value: Json): string {
  if (isArray(value)) return value.map(textOfValue).join(", ");
  if (isObject(value)) return Object.entries(value).map(([key, each]) => `${key} = ${textOfValue(each)}`).join(", ");
  return textOf(value);
}

/** A part is a file of its own: shown, and kept as it is when the model is saved. */
export function PartPanel({ id, entry }: { readonly id: EntryId; readonly entry: Entry }): ReactElement {
  const problems = useProblems(`/${id}`);
  return (
    <div className="pad form">
      <header className="form-head"><Icon name="include" size={20} /><h2>{entry.name}</h2><span className="soft">Part</span></header>
      <p className="tip">A model file as a part of this one. It is edited in its own file; here it is shown, and kept when the model is saved.</p>
      <dl className="part-fields">
        {Object.entries(entry.value).map(([key, value]) => <div key={key}><dt>{labelOf(key)}</dt><dd>{textOfValue(value)}</dd></div>)}
      </dl>
      {problems.map((each) => <p key={each.what} className={each.severity}>{each.what}</p>)}
      <Readers id={id} />
    </div>
  );
}

/** Ways to what reads the names that an entry brings, and to what it reads. */
export function Readers({ id }: { readonly id: EntryId }): ReactElement | null {
  const data = useStore((state) => state.data);
  const checked = useStore((state) => state.checked);
  // the wires are those that the last check brought
  const wires = useMemo(() => wiresOf(data), [data, checked]);
  const [reads, readBy] = [wires.filter((each) => each.target === id), wires.filter((each) => each.source === id)];
  if (reads.length + readBy.length === 0) return null;
  return (
    <>
      <Ways label="Reads" ways={reads.map(({ source, names }) => [source, names.join(", ")])} />
      <Ways label="Read by" ways={readBy.map(({ target }) => [target, entryAt(data, target)?.name ?? target])} />
    </>
  );
}

function Ways({ label, ways }: { readonly label: string; readonly ways: readonly (readonly [EntryId, string])[] }): ReactElement | null {
  if (ways.length === 0) return null;
  return (
    <div className="field">
      <div className="label"><span>{label}</span></div>
      <div className="row">
        {ways.map(([id, text]) => <button key={id} type="button" className="button small" title={`To ${text}`} onClick={() => { select([id], `${text} selected`); showNode(id); }}>{text}</button>)}
      </div>
    </div>
  );
}
