/** Inputs of single values. */

import { useEffect, useId, useState, type KeyboardEvent, type MouseEvent, type ReactElement } from "react";
import { api } from "../api";
import { textOf } from "../model/entries";
import { withValue } from "../model/pointers";
import { converted } from "../model/quantities";
import { edit, endGesture, useStore } from "../store";
import type { Json } from "../types";
import { Formula } from "./math";

/** Change the value at a pointer; typing in one field is one step of the history. */
export function setValue(pointer: string, value: Json | undefined): void {
  edit((data) => withValue(data, pointer, value), `field ${pointer}`);
}

export interface InputProps {
  readonly pointer: string;
  readonly id?: string;
  readonly describedBy?: string;
  readonly label?: string;
  readonly wrong?: boolean;
  readonly placeholder?: string;
}

interface TextProps extends InputProps {
  readonly value: string;
  /** A list of what may be meant. */
  readonly list?: string;
  readonly disabled?: boolean;
  readonly change: (text: string) => void;
  /** Called when the field is left. */
  readonly left?: () => void;
}

function attributes({ pointer, id, describedBy, label, wrong, placeholder }: InputProps): object {
  return {
    "data-pointer": pointer, id, placeholder, "aria-label": label, "aria-describedby": describedBy,
    "aria-invalid": wrong === true ? true : undefined, autoComplete: "off", spellCheck: false,
  };
}

/** A text whose every keystroke counts. */
export function LiveInput({ value, change, left, list, disabled, ...rest }: TextProps): ReactElement {
  return (
    <input
      {...attributes(rest)} value={value} list={list} disabled={disabled} onBlur={() => { left?.(); endGesture(); }}
      onChange={(event) => { change(event.target.value); }}
    />
  );
}

interface NameProps extends Omit<TextProps, "change"> {
  /** Takes a name, and returns why it cannot be, or "". */
  readonly change: (text: string) => string;
}

/** A name, which counts when the field is left or Enter is pressed; one that cannot be stays there with what is wrong. */
export function NameInput({ value, change, list, disabled, ...rest }: NameProps): ReactElement {
  const [text, setText] = useState(value);
  const [given, setGiven] = useState(value);
  const [refusal, setRefusal] = useState("");
  const refused = useId();
  if (given !== value) { // while drawing: an effect after the first drawing would drop what was typed since
    setGiven(value);
    setText(value);
    setRefusal("");
  }
  const accept = (): void => {
    setRefusal(text.trim() === value ? "" : change(text.trim()));
    endGesture();
    if (text.trim() === value) setText(value);
  };
  const press = (event: KeyboardEvent): void => {
    if (event.key === "Enter") accept();
    else if (event.key === "Escape" && text !== value) {
      event.stopPropagation(); // the first press rejects the name, the next leaves the field
      setText(value);
      setRefusal("");
    }
  };
  const wrong = refusal !== "" || rest.wrong === true;
  return (
    <div className="name-input">
      <input
        {...attributes({ ...rest, wrong, ...(refusal === "" ? {} : { describedBy: refused }) })} value={text} title={text} list={list} disabled={disabled}
        onBlur={accept} onKeyDown={press} onChange={(event) => { setText(event.target.value); }} onMouseDown={selectAtFirst}
      />
      {refusal !== "" && <p id={refused} role="alert" className="field-problem error"><span>{refusal}</span></p>}
    </div>
  );
}

/** Select the whole name at the first click, as Tab does: who goes there writes another. */
function selectAtFirst(event: MouseEvent<HTMLInputElement>): void {
  if (event.button !== 0 || document.activeElement === event.currentTarget) return;
  event.preventDefault();
  event.currentTarget.focus();
  event.currentTarget.select();
}

/** Return the mathematics of a formula: as the last check wrote it, else as the server writes it now. */
function useEcho(pointer: string, text: string): string {
  const checked = useStore((state) => (state.checked === state.data ? state.check?.formulas[pointer] : undefined));
  const [own, setOwn] = useState({ text: "", mathml: "" });
  const plain = text.trim() === "" || Number.isFinite(Number(text));
  useEffect(() => {
    if (plain || checked !== undefined) return undefined;
    const wait = setTimeout(() => {
      api.formula(text, pointer).then((mathml) => { setOwn({ text, mathml }); }, () => { setOwn({ text, mathml: "" }); });
    }, 250);
    return () => { clearTimeout(wait); };
  }, [text, pointer, plain, checked]);
  if (plain) return "";
  return checked ?? (own.text === text ? own.mathml : "");
}

export function Echo({ pointer, value }: { pointer: string; value: string }): ReactElement | null {
  const mathml = useEcho(pointer, value);
  // a single name says no more in italics
  if (mathml === "" || /^[A-Za-z]\w?$/.test(value.trim())) return null;
  return <div className="echo" aria-hidden="true"><Formula text={mathml} /></div>;
}

/** Return what turns a text with a unit into a number when its field is left, and what it then says of that. */
function useUnits(text: string, unit: string, set: (next: string) => void): readonly [() => void, ReactElement | null] {
  const [done, setDone] = useState({ text: "", note: "" });
  const left = (): void => {
    const found = converted(text, unit);
    if (found === null) return;
    setDone(found);
    set(found.text);
  };
  return [left, done.note !== "" && done.text === text ? <p className="converted" role="status">{done.note}</p> : null];
}

interface FormulaProps extends InputProps {
  readonly value: Json | undefined;
  readonly optional?: boolean;
  /** What the field is measured in; "" where any unit may be meant. */
  readonly unit?: string;
}

export function FormulaInput({ value, optional = false, unit = "", ...rest }: FormulaProps): ReactElement {
  const text = textOf(value);
  const set = (next: string): void => { setValue(rest.pointer, next === "" && optional ? undefined : next); };
  const [left, note] = useUnits(text, unit, set);
  return (
    <>
      <LiveInput {...rest} value={text} change={set} left={left} />
      {note}
      <Echo pointer={rest.pointer} value={text} />
    </>
  );
}

/** Return components after a change of one; where they may lack, all of them empty are none. */
function changedComponents(texts: readonly string[], index: number, next: string, fill: string): string[] | undefined {
  const changed = texts.map((text, place) => (place === index ? next : text));
  if (fill === "" && changed.every((text) => text === "")) return undefined;
  return changed.map((text, place) => (text === "" && place !== index ? "0" : text));
}

/** Components of a vector side by side; the whole of them is changed. `fill` stands where there are none. */
export function VectorInput({ pointer, value, labels, label, unit = "", fill = "0" }: {
  readonly unit?: string; readonly pointer: string; readonly value: readonly Json[]; readonly labels: readonly string[]; readonly label: string; readonly fill?: string;
}): ReactElement { // prettier-ignore
  const problems = useStore((state) => state.check?.problems);
  const texts = labels.map((_, index) => textOf(value[index] ?? fill));
  return (
    <div className="vector" style={{ gridTemplateColumns: `repeat(${Math.min(3, labels.length)}, minmax(0, 1fr))` }}>
      {labels.map((each, index) => {
        const own = `${pointer}/${index}`;
        return (
          <Component
            key={own} pointer={own} name={each} label={`${label} ${each}`} text={texts[index]!} unit={unit} wrong={problems?.some((problem) => problem.pointer === own) ?? false}
            set={(next) => { setValue(pointer, changedComponents(texts, index, next, fill)); }}
          />
        );
      })}
    </div>
  );
}

function Component({ pointer, name, label, text, unit, wrong, set }: {
  readonly pointer: string; readonly name: string; readonly label: string; readonly text: string; readonly unit: string; readonly wrong: boolean; readonly set: (next: string) => void;
}): ReactElement { // prettier-ignore
  const [left, note] = useUnits(text, unit, set);
  return (
    <label>
      <span aria-hidden="true">{name}</span>
      <LiveInput pointer={pointer} value={text} label={label} wrong={wrong} change={set} left={left} />
      {note}
      <Echo pointer={pointer} value={text} />
    </label>
  );
}

export function Choice({ pointer, value, options, change, id, describedBy, label }: InputProps & {
  readonly value: string; readonly options: readonly { readonly value: string; readonly text: string }[]; readonly change: (value: string) => void;
}): ReactElement { // prettier-ignore
  const missing = !options.some((each) => each.value === value);
  return (
    <select id={id} data-pointer={pointer} aria-describedby={describedBy} aria-label={label} value={value} onChange={(event) => { endGesture(); change(event.target.value); }}>
      {missing && <option value={value}>{value === "" ? "—" : `${value} (missing)`}</option>}
      {options.map((each) => <option key={each.value} value={each.value}>{each.text}</option>)}
    </select>
  );
}
