/** The equations, a tab for each part; long ones in blocks. */

import { useState, type MouseEvent, type ReactElement } from "react";
import { giveCommand } from "../commands/all";
import { download } from "../commands/files";
import { entryNamed } from "../model/entries";
import { isArray, isObject } from "../model/pointers";
import { textOf } from "../model/entries";
import { Formula } from "../panels/math";
import { Icon } from "../shell/icons";
import { say, useStore } from "../store";
import type { Json, JsonObject } from "../types";

/** More than this and a block is shown when it is opened. */
const MOST_MATH = 12_000; // characters of MathML

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

export function Equations(): ReactElement {
  const equations = useStore((state) => state.equations);
  const stale = useStore((state) => state.equations !== null && state.equations.of !== state.data);
  const [shown, setShown] = useState("");
  if (equations === null) {
    return (
      <div className="pad soft">
        <p>The equations of motion, written out: mass matrix, forcing, constraints, kinematics.</p>
        <button type="button" className="button" onClick={() => { giveCommand("equations"); }}><Icon name="sum" size={16} /> Derive the equations <kbd>F6</kbd></button>
      </div>
    );
  }
  const list = equations.result?.["tabs"];
  const tabs = (isArray(list) ? list : []).filter(isObject).map((each) => ({ name: textOf(each["name"]), blocks: isArray(each["blocks"]) ? each["blocks"].map(blockOf) : [] }));
  const tab = tabs.find((each) => each.name === shown) ?? tabs[0];
  return (
    <div className="equations">
      <div className="subtabs"><div role="tablist" aria-label="Equations">
        {tabs.map((each) => <button key={each.name} type="button" role="tab" aria-selected={each === tab} onClick={() => { setShown(each.name); }}>{each.name}</button>)}</div>
        {stale && <button type="button" className="button small" onClick={() => { giveCommand("equations"); }}>Before the last edits: derive again</button>}
      </div>
      <div className="equation-blocks" role="tabpanel" tabIndex={0} aria-label={tab?.name}>
        {tab?.blocks.map((block, index) => <EquationBlock key={`${tab.name} ${index}`} block={block} />)}
      </div>
    </div>
  );
}

function EquationBlock({ block }: { readonly block: Block }): ReactElement {
  const long = block.mathml.length > MOST_MATH;
  const [open, setOpen] = useState(!long);
  return (
    <section className="equation-block" aria-label={block.title} onClick={(event) => { lightUp(event, block); }}>
      <header><h3>{block.title}</h3><CopyButtons block={block} /></header>
      {block.mathml !== "" && open && <div className="maths" tabIndex={0}><Formula text={block.mathml} block /></div>}
      {block.mathml !== "" && !open && <button type="button" className="button small" onClick={() => { setOpen(true); }}>Show it: {Math.round(block.characters / 1000)} thousand characters</button>}
      {block.mathml === "" && <p className="soft">{block.characters} characters: too long to be read here. Copy it, or write it to a file.</p>}
    </section>
  );
}

/** Light up in diagram and picture what a term comes from. */
function lightUp(event: MouseEvent, block: Block): void {
  const span = (event.target as Element).closest("[data-span]")?.getAttribute("data-span");
  const elements = block.sources.find((each) => each.span === span)?.elements ?? [];
  if (elements.length === 0) return;
  const { data } = useStore.getState();
  const ids = elements.map((name) => entryNamed(data, name)?.id ?? null).filter((id) => id !== null);
  useStore.setState({ highlighted: ids, spoken: `Comes from ${elements.join(", ")}` });
}

const FORMS = [["latex", "LaTeX", ".tex"], ["sympy", "SymPy", ".py"], ["c", "C", ".c"]] as const;

function CopyButtons({ block }: { readonly block: Block }): ReactElement {
  const copy = (text: string, name: string): void => {
    navigator.clipboard.writeText(text).then(() => { say(`${name} copied`); }, () => { say("The browser did not let it be copied."); });
  };
  return (
    <span className="copy-buttons">
      {FORMS.filter(([form]) => block.forms[form] !== "").map(([form, name, ending]) => block.forms[form].length < 200_000
        ? <button key={form} type="button" className="button small" title={`Copy as ${name}`} onClick={() => { copy(block.forms[form], name); }}>Copy {name}</button>
        : <button key={form} type="button" className="button small" onClick={() => { download(`${block.title}${ending}`, block.forms[form]); }}>Write {name}</button>)}
    </span>
  );
}
