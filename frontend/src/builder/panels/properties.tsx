/** The right side: the fields of what is selected, or of the model. */

import { useMemo, type ReactElement } from "react";
import { duplicate, removeSelection } from "../commands/editing";
import { joins } from "../commands/insert";
import { changeType } from "../model/edit";
import { entryAt, GROUND, INPUTS, PART, type Entry, type EntryId } from "../model/entries";
import { isObject, valueAt } from "../model/pointers";
import { definitionNode, elementOf } from "../model/schema";
import { hiddenFields } from "../model/signal_forms";
import { Icon } from "../shell/icons";
import { edit, endGesture, useStore } from "../store";
import type { PaletteElement, SchemaAnswer } from "../types";
import { ProblemLines } from "./field_frame";
import { Choice } from "./inputs";
import { ModelPanel } from "./model_panel";
import { Fields } from "./field";
import { InputPanel, PartPanel, Readers } from "./signal_panels";
import { SignalKind } from "./signal_kind";

export function Properties(): ReactElement {
  const selection = useStore((state) => state.selection);
  const schema = useStore((state) => state.schema);
  const [id] = selection;
  let content: ReactElement;
  if (schema === null) content = <p className="soft pad">Loading…</p>;
  else if (id === undefined) content = <ModelPanel />;
  else if (selection.length > 1) content = <SeveralPanel count={selection.length} />;
  else content = <EntryPanel key={id} id={id} schema={schema} />;
  return <section className="properties" aria-label="Properties" data-testid="properties">{content}</section>;
}

function SeveralPanel({ count }: { readonly count: number }): ReactElement {
  return (
    <div className="pad">
      <h2>{count} elements</h2>
      <p className="soft">Select a single element to see its properties. Drag, arrow keys, copy and delete act on all selected elements.</p>
      <EntryButtons />
    </div>
  );
}

function EntryButtons(): ReactElement {
  return (
    <div className="row">
      <button type="button" className="button small" onClick={duplicate}><Icon name="copy" size={14} /> Duplicate</button>
      <button type="button" className="button small" onClick={removeSelection}><Icon name="trash" size={14} /> Delete</button>
    </div>
  );
}

function EntryPanel({ id, schema }: { readonly id: EntryId; readonly schema: SchemaAnswer }): ReactElement {
  const data = useStore((state) => state.data);
  const entry = entryAt(data, id);
  if (id === GROUND) return <GroundPanel schema={schema} />;
  if (entry?.section === INPUTS) return <InputPanel id={id} entry={entry} buttons={<EntryButtons />} />;
  if (entry?.section === PART) return <PartPanel id={id} entry={entry} />;
  return <ElementPanel id={id} entry={entry} schema={schema} />;
}

function ElementPanel({ id, entry, schema }: { readonly id: EntryId; readonly entry: Entry | null; readonly schema: SchemaAnswer }): ReactElement {
  const element = entry === null ? null : elementOf(schema.elements, entry.section, entry.type);
  if (entry === null || element === null) return <p className="soft pad">This type of element is unknown.</p>;
  const node = definitionNode(schema.schema, element.definition);
  return (
    <div className="pad form">
      <header className="form-head">
        <Icon name={element.type} fallback={element.section} size={20} />
        <h2>{entry.name}</h2>
        <span className="soft">{element.title}</span>
      </header>
      <p className="tip">{element.summary}</p>
      <EntryProblems id={id} />
      <TypeChoice entry={entry} element={element} schema={schema} />
      {entry.section === "signal" && <SignalKind entry={entry} />}
      <Fields node={node} pointer={`/${id}`} value={entry.value} skip={entry.section === "signal" ? hiddenFields(entry.value) : []} />
      <Readers id={id} />
      <EntryButtons />
    </div>
  );
}

function EntryProblems({ id }: { readonly id: EntryId }): ReactElement {
  const problems = useStore((state) => state.check?.problems);
  return <ProblemLines problems={(problems ?? []).filter((each) => each.pointer === `/${id}`)} />;
}

function TypeChoice({ entry, element, schema }: { readonly entry: Entry; readonly element: PaletteElement; readonly schema: SchemaAnswer }): ReactElement | null {
  const others = useMemo(
    () => schema.elements.filter((each) => each.section === element.section && joins(each) === joins(element)),
    [schema, element],
  );
  if (others.length < 2) return null;
  const change = (type: string): void => {
    const next = others.find((each) => each.type === type);
    endGesture();
    if (next !== undefined) edit((data) => changeType(schema.schema, data, entry.id, next));
  };
  return (
    <div className="field">
      <div className="label"><label htmlFor="entry-type">Type</label></div>
      <Choice id="entry-type" pointer={`/${entry.id}/type`} value={element.type} options={others.map((each) => ({ value: each.type, text: each.title }))} change={change} />
      <p className="tip">Changing the type keeps the name, the frames, and the fields that both types have.</p>
    </div>
  );
}

function GroundPanel({ schema }: { readonly schema: SchemaAnswer }): ReactElement {
  const ground = useStore((state) => valueAt(state.data, "/ground"));
  const properties = schema.schema["properties"];
  const node = isObject(properties) ? properties["ground"] : undefined;
  const name = isObject(node) && typeof node["$ref"] === "string" ? node["$ref"].split("/").at(-1)! : "";
  return (
    <div className="pad form">
      <header className="form-head"><Icon name="ground" size={20} /><h2>Ground</h2><span className="soft">The fixed frame</span></header>
      <EntryProblems id={GROUND} />
      <Fields node={definitionNode(schema.schema, name)} pointer="/ground" value={isObject(ground) ? ground : {}} />
    </div>
  );
}
