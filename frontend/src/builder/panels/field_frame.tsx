/** What surrounds a field: its label, unit, tip, and what is wrong with it. */

import { useId, type ReactElement, type ReactNode } from "react";
import { repair } from "../commands/editing";
import { isNameIn } from "../model/names";
import { Icon } from "../shell/icons";
import { useStore } from "../store";
import type { Problem } from "../types";

/** Return the problems of a place, and of what is in it where `deep`. */
export function useProblems(pointer: string, deep = true): readonly Problem[] {
  const problems = useStore((state) => state.check?.problems);
  return (problems ?? []).filter((each) => each.pointer === pointer || (deep && each.pointer.startsWith(`${pointer}/`)));
}

interface FrameProps {
  readonly label: string;
  readonly unit?: string;
  readonly tip?: string;
  readonly problems: readonly Problem[];
  /** Called with the id of the control and the ids of what describes it. */
  readonly children: (id: string, describedBy: string) => ReactNode;
}

export function FieldFrame({ label, unit = "", tip = "", problems, children }: FrameProps): ReactElement {
  const id = useId();
  return (
    <div className={`field${problems.some((each) => each.severity === "error") ? " wrong" : ""}`}>
      <div className="label"><label htmlFor={id}>{label}</label>{unit !== "" && <span className="unit">{unit}</span>}</div>
      {children(id, `${id}-tip ${id}-wrong`)}
      {tip !== "" && <p className="tip" id={`${id}-tip`}>{tip}</p>}
      <ProblemLines id={`${id}-wrong`} problems={problems} />
    </div>
  );
}

/** A group of controls with a legend instead of a label. */
export function FieldGroup({ label, unit = "", tip = "", problems, children }: Omit<FrameProps, "children"> & { readonly children: ReactNode }): ReactElement {
  return (
    <fieldset className={`field${problems.some((each) => each.severity === "error") ? " wrong" : ""}`}>
      <legend>{label}{unit !== "" && <span className="unit">{unit}</span>}</legend>
      {children}
      {tip !== "" && <p className="tip">{tip}</p>}
      <ProblemLines problems={problems} />
    </fieldset>
  );
}

/** Return problems without those that say the same as one before, and how many say it. */
export function grouped(problems: readonly Problem[]): readonly (readonly [Problem, number])[] {
  const groups = new Map<string, readonly [Problem, number]>();
  for (const each of problems) {
    const key = JSON.stringify([each.severity, each.code, each.what]);
    const [first, count] = groups.get(key) ?? [each, 0];
    groups.set(key, [first, count + 1]);
  }
  return [...groups.values()];
}

export function Times({ count }: { readonly count: number }): ReactElement | null {
  return count === 1 ? null : <b> The same in {count - 1} other {count === 2 ? "place" : "places"}.</b>;
}

export function ProblemLines({ id, problems }: { id?: string; problems: readonly Problem[] }): ReactElement {
  return (
    <div id={id} role={problems.length > 0 ? "alert" : undefined} className="field-problems">
      {grouped(problems).map(([each, count]) => (
        <div key={`${each.code}${each.pointer}${each.what}`} className={`field-problem ${each.severity}`}>
          <Icon name={each.severity} size={14} />
          <span>{each.line !== null && <b>Line {each.line}: </b>}<What text={each.what} /> {each.fix !== "" && <em>{sentence(each.fix)}</em>}<Times count={count} /></span>
          {each.repair !== null && <button type="button" className="button small" onClick={() => { repair(each); }}>{each.repair.label}</button>}
        </div>
      ))}
    </div>
  );
}

/** What a problem is; lines after the first show a place in a text. */
export function What({ text }: { readonly text: string }): ReactElement {
  const [head = "", ...lines] = text.trim().split("\n");
  return <>{sentence(head)}{lines.length > 0 && <code className="place">{lines.map((each) => each.replace(/^ {4}/, "")).join("\n")}</code>}</>;
}

/** Return a text with a full stop at its end and a capital at its start, unless it starts with a name of the model. */
export function sentence(text: string): string {
  const trimmed = text.trim();
  if (trimmed === "") return "";
  const [word = ""] = /^[\p{L}\p{N}_]*/u.exec(trimmed) ?? [];
  const first = trimmed.charAt(0);
  const start = isNameIn(useStore.getState().data, word) ? first : first.toUpperCase();
  return start + trimmed.slice(1) + (/[.!?:]$/.test(trimmed) ? "" : ".");
}
