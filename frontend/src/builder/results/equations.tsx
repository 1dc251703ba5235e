/** The equations, a tab for each part; long ones in blocks. */

import { useEffect, useMemo, useState, type MouseEvent, type ReactElement } from "react";
import { giveCommand } from "../commands/all";
import { download } from "../commands/files";
import { writeTab } from "../commands/jobs";
import { entryNamed, type EntryId } from "../model/entries";
import { isArray, isObject } from "../model/pointers";
import { textOf } from "../model/entries";
import { EquationRows } from "../panels/math";
import { Icon } from "../shell/icons";
import { say, useStore } from "../store";
import type { Json, JsonObject } from "../types";

/** More than this and a block is shown when it is opened. */
const MOST_MATH = 40_000; // characters of MathML

interface Block {
  readonly title: string;
  readonly mathml: string;
  readonly forms: Readonly<Record<"latex" | "sympy" | "c", string>>;
  readonly characters: number;
  readonly sources: readonly { readonly span: string; readonly elements: readonly string[] }[];
}

function blockOf(value: Json): Block {
  const block: JsonObject = isObject(value) ? value : {};
  const sources = isArray(block["sources"]) ? block["sources"].filter(isObject) : [];
  return {
    title: textOf(block["title"]),
    mathml: textOf(block["mathml"] ?? ""),
    forms: { latex: textOf(block["latex"] ?? ""), sympy: textOf(block["sympy"] ?? ""), c: textOf(block["c"] ?? "") },
    characters: Number(block["characters"] ?? 0),
    sources: sources.map((each) => ({ span: textOf(each["span"]), elements: isArray(each["elements"]) ? each["elements"].map(textOf) : [] })),
  };
}

interface Tab {
  readonly name: string;
  readonly blocks: readonly Block[];
  readonly note: string;
}

function tabOf(value: JsonObject): Tab {
  return { name: textOf(value["name"]), blocks: isArray(value["blocks"]) ? value["blocks"].map(blockOf) : [], note: textOf(value["note"] ?? "") };
}

/** Return the names of all tabs of the last equations, and those that are written. */
function useTabs(): { readonly names: readonly string[]; readonly written: readonly Tab[] } {
  const result = useStore((state) => state.equations?.result);
  return useMemo(() => {
    const [names, list] = [result?.["names"], result?.["tabs"]];
    return { names: isArray(names) ? names.map(textOf) : [], written: isArray(list) ? list.filter(isObject).map(tabOf) : [] };
  }, [result]);
}

export function Equations(): ReactElement {
  const [shown, setShown] = useState("");
  const { names, written } = useTabs();
  const name = names.includes(shown) ? shown : names[0];
  const tab = written.find((each) => each.name === name);
  useEffect(() => () => { glow([]); }, []);
  useEffect(() => { if (name !== undefined && tab === undefined) void writeTab(name); }, [name, tab]);
  if (name === undefined) return <NotDerived />;
  return (
    <div className="equations">
      <div className="subtabs"><div role="tablist" aria-label="Equations">
        {names.map((each) => <button key={each} type="button" role="tab" aria-selected={each === name} onClick={() => { setShown(each); }}>{each}</button>)}</div>
        <TabsNote />
      </div>
      <div className="equation-blocks" role="tabpanel" tabIndex={0} aria-label={name} aria-busy={tab === undefined}>
        {tab === undefined ? <p className="soft pad" role="status">Writing…</p> : tab.note !== "" && <p className="soft pad">{tab.note}</p>}
        {tab?.blocks.map((block, index) => <EquationBlock key={`${name} ${index}`} block={block} />)}
      </div>
    </div>
  );
}

function NotDerived(): ReactElement {
  const deriving = useStore((state) => state.runs.equations !== undefined);
  if (deriving) return <p className="soft pad" role="status">Being derived…</p>;
  return (
    <div className="pad soft">
      <p>The equations of motion in full: mass matrix, forcing, constraints, kinematics.</p>
      <button type="button" className="button" onClick={() => { giveCommand("equations"); }}><Icon name="sum" size={16} /> Derive the equations <kbd>F6</kbd></button>
    </div>
  );
}

/** Whether these are of the model as it is. */
function TabsNote(): ReactElement | null {
  const stale = useStore((state) => state.equations !== null && state.equations.of !== state.data);
  return stale ? <button type="button" className="button small" onClick={() => { giveCommand("equations"); }}>Derived before the last edits: derive again</button> : null;
}

function EquationBlock({ block }: { readonly block: Block }): ReactElement {
  const long = block.mathml.length > MOST_MATH;
  const [open, setOpen] = useState(!long);
  return (
    <section className="equation-block" aria-label={block.title} onClick={(event) => { lightUp(event, block); }} onPointerOver={(event) => { glow(idsOf(sourcesOf(event, block))); }} onPointerLeave={() => { glow([]); }}>
      <header><h3>{block.title}</h3><CopyButtons block={block} /></header>
      {block.mathml !== "" && open && <div className="maths" tabIndex={0}><EquationRows text={block.mathml} /></div>}
      {block.mathml !== "" && !open && <button type="button" className="button small" onClick={() => { setOpen(true); }}>Show it: {Math.round(block.characters / 1000)} thousand characters</button>}
      {block.mathml === "" && <p className="soft">{block.characters} characters: too long to be read here. Copy it, or write it to a file.</p>}
    </section>
  );
}

/** Return the names of what the term under the pointer comes from. */
function sourcesOf({ target }: MouseEvent, block: Block): readonly string[] {
  const span = (target as Element).closest("[data-span]")?.getAttribute("data-span");
  return block.sources.find((each) => each.span === span)?.elements ?? [];
}

function idsOf(elements: readonly string[]): readonly EntryId[] {
  const { data } = useStore.getState();
  return elements.map((name) => entryNamed(data, name)?.id ?? null).filter((id) => id !== null);
}

/** Light up in the diagram what a term comes from. */
function lightUp(event: MouseEvent, block: Block): void {
  const elements = sourcesOf(event, block);
  if (elements.length > 0) useStore.setState({ highlighted: idsOf(elements), spoken: `Comes from ${elements.join(", ")}` });
}

/** Light up lightly what is pointed at, without a word: the pointer passes many terms. */
function glow(ids: readonly EntryId[]): void {
  const { glowing } = useStore.getState();
  if (ids.join() !== glowing.join()) useStore.setState({ glowing: ids });
}

const FORMS = [["latex", "LaTeX", ".tex"], ["sympy", "SymPy", ".py"], ["c", "C", ".c"]] as const;

function CopyButtons({ block }: { readonly block: Block }): ReactElement {
  const copy = (text: string, name: string): void => {
    navigator.clipboard.writeText(text).then(() => { say(`${name} copied`); }, () => { say("The browser does not allow copying."); });
  };
  return (
    <span className="copy-buttons">
      {FORMS.filter(([form]) => block.forms[form] !== "").map(([form, name, ending]) => block.forms[form].length < 200_000
        ? <button key={form} type="button" className="button small" title={`Copy as ${name}`} onClick={() => { copy(block.forms[form], name); }}>Copy {name}</button>
        : <button key={form} type="button" className="button small" onClick={() => { download(`${block.title}${ending}`, block.forms[form]); }}>Export {name}</button>)}
    </span>
  );
}
