/** The rotation tree and the translation tree, in step with the diagram. */

import type { ReactElement } from "react";
import { endsOf, entriesOf, GROUND, referenceOf, type Entry } from "../model/entries";
import { isInTree, withTree, type TreeName } from "../model/trees";
import { Icon } from "../shell/icons";
import { edit, endGesture, select, useStore } from "../store";
import type { Model, Summary } from "../types";

interface Branch {
  readonly body: string;
  readonly joint: Entry | null;
  readonly children: readonly Branch[];
}

/** Return the tree that joints span from the ground. */
export function treeFrom(data: Model, summary: Summary | null, name: TreeName): Branch {
  const joints = entriesOf(data).filter((each) => each.section === "joint" && isInTree(data, summary, each.id, name) === true);
  const reached = new Set([GROUND]);
  const grow = (body: string, joint: Entry | null): Branch => {
    const out = joints.flatMap((each) => {
      const bodies = endsOf(each.value)?.map((end) => referenceOf(end).body) ?? [];
      const next = bodies[0] === body ? bodies[1] : bodies[1] === body ? bodies[0] : undefined;
      if (next === undefined || reached.has(next)) return [];
      reached.add(next);
      return [{ next, each }];
    });
    return { body, joint, children: out.map(({ next, each }) => grow(next, each)) };
  };
  return grow(GROUND, null);
}

export function Trees(): ReactElement {
  return (
    <div className="trees" data-testid="trees">
      <TreeView name="rotation" title="Rotation tree" />
      <TreeView name="translation" title="Translation tree" />
      <Chords />
    </div>
  );
}

function TreeView({ name, title }: { readonly name: TreeName; readonly title: string }): ReactElement {
  const data = useStore((state) => state.data);
  const summary = useStore((state) => state.check?.summary ?? null);
  const out = entriesOf(data).filter((each) => each.section === "joint" && isInTree(data, summary, each.id, name) !== true);
  return (
    <section aria-label={title}>
      <h3>{title}</h3>
      <ul className="tree-view"><BranchView branch={treeFrom(data, summary, name)} name={name} /></ul>
      {out.length > 0 && <div className="cotree"><span className="soft">Excluded</span>{out.map((each) => <JointRow key={each.id} joint={each} name={name} inside={false} body="" />)}</div>}
    </section>
  );
}

function BranchView({ branch, name }: { readonly branch: Branch; readonly name: TreeName }): ReactElement {
  return (
    <li>
      {branch.joint === null ? <span className="tree-root"><Icon name="ground" size={15} /> Ground</span> : <JointRow joint={branch.joint} name={name} inside body={branch.body} />}
      {branch.children.length > 0 && <ul>{branch.children.map((each) => <BranchView key={each.joint!.id} branch={each} name={name} />)}</ul>}
    </li>
  );
}

function JointRow({ joint, name, inside, body }: { readonly joint: Entry; readonly name: TreeName; readonly inside: boolean; readonly body: string }): ReactElement {
  const selected = useStore((state) => state.selection.includes(joint.id));
  const toggle = (): void => {
    endGesture();
    edit((data) => withTree(data, joint.id, name, !inside));
  };
  return (
    <div className={`tree-row${selected ? " selected" : ""}`} onContextMenu={(event) => { event.preventDefault(); select([joint.id]); useStore.setState({ popup: { kind: "menu", x: event.clientX, y: event.clientY, target: joint.id } }); }}>
      <input type="checkbox" checked={inside} onChange={toggle} aria-label={`${joint.name} in the ${name} tree`} title={inside ? "Remove it from the tree" : "Put it into the tree"} />
      <button type="button" title={body === "" ? joint.name : `${joint.name}: ${body}`} onClick={() => { select([joint.id], `${joint.name} selected`); }}>
        <Icon name={joint.type} fallback={joint.section} size={15} /> <b>{joint.name}</b> <span className="soft">{body === "" ? joint.type.replaceAll("_", " ") : body}</span>
      </button>
    </div>
  );
}

/** What the joints outside the trees add, and what of it is redundant. */
function Chords(): ReactElement | null {
  const summary = useStore((state) => state.check?.summary ?? null);
  const wrong = useStore((state) => state.check?.problems.some((each) => each.severity === "error") ?? false);
  if (summary === null || wrong) return null;
  return (
    <section aria-label="Loops">
      <h3>Loops</h3>
      {summary.chords.length === 0 && <p className="soft">No cut joints: the joints form a tree.</p>}
      {summary.chords.map((each) => (
        <p key={each.joint} className="loop-line"><b>{each.joint}</b> closes {each.loop.length > 0 ? each.loop.join(" – ") : "a loop"}: {each.equations} constraint {each.equations === 1 ? "equation" : "equations"}</p>
      ))}
      {summary.counting.map((each) => <p key={each} className="loop-line">{each}</p>)}
      {summary.redundant.map((each) => <p key={each} className="loop-line warning"><Icon name="warning" size={14} /> redundant: {each}</p>)}
    </section>
  );
}
