/** Everything that is wrong; a click leads to the field. */

import type { ReactElement } from "react";
import { repair } from "../commands/editing";
import { showNode } from "../diagram/flow";
import { entryAt, entryNamed, entryOfPointer } from "../model/entries";
import { splitPointer } from "../model/pointers";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import type { Problem, Severity } from "../types";
import { grouped, sentence, Times, What } from "./field_frame";

const ORDER: readonly Severity[] = ["error", "warning", "note"];

/** Select what a problem is of and focus its field. */
export function goTo({ pointer, element }: Problem): void {
  const { data } = useStore.getState();
  const id = entryOfPointer(pointer) ?? entryNamed(data, element)?.id ?? null;
  select(id === null ? [] : [id]);
  useStore.setState({ focusPointer: pointer });
  if (id !== null) showNode(id);
}

export function useAllProblems(): readonly Problem[] {
  const check = useStore((state) => state.check);
  const open = useStore((state) => state.openProblems);
  const problems = check === null ? open : check.problems;
  return [...problems].sort((a, b) => ORDER.indexOf(a.severity) - ORDER.indexOf(b.severity));
}

/** Whether something has to be done: notes only say what is. */
export function isFault({ severity }: Problem): boolean {
  return severity !== "note";
}

/** What is worth knowing though nothing is wrong. */
export function Notes(): ReactElement {
  const notes = useAllProblems().filter((each) => !isFault(each));
  if (notes.length === 0) return <p className="soft pad">No notes.</p>;
  return <ul className="problem-list" aria-label="Notes"><ProblemItems problems={notes} /></ul>;
}

export function Problems(): ReactElement {
  const problems = useAllProblems().filter(isFault);
  const checked = useStore((state) => state.checked !== null);
  if (problems.length === 0) {
    return <p className="soft pad good"><Icon name="check" size={16} /> {checked ? "No problems." : "Checking…"}</p>;
  }
  return (
    <ul className="problem-list" aria-label="Problems">
      <ProblemItems problems={problems} />
    </ul>
  );
}

function ProblemItems({ problems }: { readonly problems: readonly Problem[] }): ReactElement {
  return <>{grouped(problems).map(([each, count], index) => <ProblemItem key={`${each.code}${each.pointer}${index}`} problem={each} count={count} />)}</>;
}

function ProblemItem({ problem, count }: { readonly problem: Problem; readonly count: number }): ReactElement {
  const data = useStore((state) => state.data);
  const id = entryOfPointer(problem.pointer);
  const field = splitPointer(problem.pointer).slice(id === null ? 0 : 2).join(" ");
  const where = [id === null ? problem.element : (entryAt(data, id)?.name ?? id), field].filter((each) => each !== "").join(", ");
  return (
    <li className={`problem ${problem.severity}`}>
      <button type="button" className="problem-go" onClick={() => { goTo(problem); }} data-testid="problem">
        <Icon name={problem.severity} size={16} />
        <span>
          <b>{problem.severity}{where === "" ? "" : ` in ${where}`}{problem.line === null ? "" : `, line ${problem.line}`}:</b> <What text={problem.what} /> {sentence(problem.why)} <em>{sentence(problem.fix)}</em>
          <Times count={count} />
        </span>
      </button>
      {problem.repair !== null && <button type="button" className="button small" onClick={() => { repair(problem); }}>{problem.repair.label}</button>}
    </li>
  );
}
