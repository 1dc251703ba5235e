/** The model's own properties: name, gravity, parameters, inputs, initial values. */

import { useId, useState, type ReactElement } from "react";
import { expectChanges } from "../checking";
import { freeName, INPUTS, symbolsOf, textOf } from "../model/entries";
import { meaningOf } from "../model/fields";
import { isExact, withPriority } from "../model/initial";
import { isArray, isObject, joinPointer, valueAt, withValue } from "../model/pointers";
import { renameInitial, renameParameter } from "../model/rename";
import { Icon } from "../shell/icons";
import { acceptKey, acceptName, acceptSymbol } from "../rename_command";
import { edit, endGesture, useStore } from "../store";
import type { Json } from "../types";
import { FieldFrame, FieldGroup, ProblemLines, useProblems } from "./field_frame";
import { Choice, FormulaInput, LiveInput, NameInput, setValue, VectorInput } from "./inputs";

export function ModelPanel(): ReactElement {
  const data = useStore((state) => state.data);
  const gravity = valueAt(data, "/gravity");
  return (
    <div className="pad form">
      <header className="form-head"><Icon name="file" size={20} /><h2>Model</h2></header>
      <FieldFrame label="Name" problems={useProblems("/name")}>
        {(id, describedBy) => <LiveInput pointer="/name" id={id} describedBy={describedBy} value={textOf(data["name"])} change={(text) => { setValue("/name", text === "" ? undefined : text); }} />}
      </FieldFrame>
      <FieldGroup label="Gravity" unit="m/s²" tip="Acceleration of gravity, in ground axes." problems={useProblems("/gravity")}>
        <VectorInput pointer="/gravity" value={isArray(gravity) ? gravity : []} labels={["x", "y", "z"]} label="Gravity" />
        {gravity === undefined && <GravityButtons />}
      </FieldGroup>
      <Table section="parameters" title="Parameters" tip="Values, or formulas in other parameters." unnamed="p1" rename={renameOfParameter} />
      <Inputs />
      <Table section="initial" title="Initial values" tip="Initial values of coordinates and speeds; others start at zero, or where the loops close. Closing the loops does not change an exact value; it may change a guess." unnamed="" rename={renameOfInitial} />
    </div>
  );
}

function GravityButtons(): ReactElement {
  const set = (value: readonly Json[]): void => {
    endGesture();
    setValue("/gravity", value);
  };
  return (
    <div className="row">
      <button type="button" className="button small" onClick={() => { set(["0", "-9.81", "0"]); }}>9.81 down y</button>
      <button type="button" className="button small" onClick={() => { set(["0", "0", "-9.81"]); }}>9.81 down z</button>
    </div>
  );
}

function renameOfParameter(before: string, after: string): string {
  return acceptSymbol(before, after, renameParameter);
}

function renameOfInitial(before: string, after: string): string {
  return acceptKey(useStore.getState().data["initial"], before, after, renameInitial);
}

interface TableProps {
  readonly section: "parameters" | "initial";
  readonly title: string;
  readonly tip: string;
  /** What a new row is called; nothing where names are those of coordinates. */
  readonly unnamed: string;
  readonly rename: (before: string, after: string) => string;
}

function Table({ section, title, tip, unnamed, rename }: TableProps): ReactElement {
  const values = useStore((state) => state.data[section]);
  const list = useId();
  const names = useInitialNames(section);
  const fields = isObject(values) ? values : {};
  const problems = useProblems(`/${section}`, false);
  const add = (): void => {
    const free = names.find((each) => fields[each] === undefined);
    const name = unnamed === "" ? (free ?? freeName("q", new Set(Object.keys(fields)))) : freeName(unnamed, new Set(Object.keys(fields)));
    endGesture();
    edit((data) => withValue(data, `/${section}${joinPointer(name)}`, unnamed === "" ? "0" : "1"));
    useStore.setState({ focusPointer: `/${section}${joinPointer(name)}${unnamed === "" ? "" : "#name"}` });
  };
  return (
    <fieldset className="field table" data-testid={section} onFocus={section === "parameters" ? expectChanges : undefined}>
      <legend>{title}</legend>
      <datalist id={list}>{names.map((each) => <option key={each} value={each} />)}</datalist>
      {Object.entries(fields).map(([name, value], index) => <TableRow key={index} section={section} name={name} value={value} list={list} rename={rename} />)}
      <button type="button" className="button small" onClick={add}><Icon name="plus" size={14} /> Add {section === "initial" ? "an initial value" : "a parameter"}</button>
      <p className="tip">{tip}</p>
      <ProblemLines problems={problems} />
    </fieldset>
  );
}

/** Return what initial values can be of. */
function useInitialNames(section: string): readonly string[] {
  const summary = useStore((state) => state.check?.summary);
  return section === "initial" && summary != null ? [...summary.coordinates, ...summary.speeds] : [];
}

function TableRow({ section, name, value, list, rename }: { readonly section: string; readonly name: string; readonly value: Json; readonly list: string; rename: TableProps["rename"] }): ReactElement {
  const pointer = `/${section}${joinPointer(name)}`;
  const problems = useProblems(pointer);
  const meaning = useMeaning(section, name);
  return (
    <div className="table-row">
      <NameInput pointer={`${pointer}#name`} label={`Name of ${name}`} value={name} change={(text) => rename(name, text)} list={section === "initial" ? list : ""} />
      <span aria-hidden="true">=</span>
      <div><FormulaInput pointer={isObject(value) ? `${pointer}/value` : pointer} value={isObject(value) ? value["value"] : value} label={name} wrong={problems.some((each) => each.severity === "error")} />{section === "parameters" && <ParameterSlider key={name} pointer={pointer} name={name} value={value} />}{section === "initial" && <PriorityChoice pointer={pointer} name={name} value={value} />}</div>
      <button type="button" className="icon-button" aria-label={`Remove ${name}`} title={`Remove ${name}`} onClick={() => { endGesture(); edit((data) => withValue(data, pointer, undefined)); }}><Icon name="trash" size={14} /></button>
      {meaning !== "" && <p className="tip meaning">{meaning}</p>}
      <ProblemLines problems={problems} />
    </div>
  );
}

/** Return the unit of a parameter and what the file says of it. */
function useMeaning(section: string, name: string): string {
  const unit = useStore((state) => state.check?.summary?.units[name]);
  const comment = useStore((state) => state.document?.comments[name]);
  return section === "parameters" ? meaningOf(unit ?? "", comment ?? "") : "";
}

const PRIORITIES = [{ value: "guess", text: "Guess" }, { value: "exact", text: "Exact" }] as const;

/** Whether the loops may move an initial value. */
function PriorityChoice({ pointer, name, value }: { readonly pointer: string; readonly name: string; readonly value: Json }): ReactElement {
  const change = (next: string): void => { edit((data) => withPriority(data, name, next === "exact")); };
  return <Choice pointer={`${pointer}/priority`} label={`Priority of ${name}`} value={isExact(value) ? "exact" : "guess"} options={PRIORITIES} change={change} />;
}

const NUMBER = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(deg)?\s*$/i;

/** A slider of a parameter that is a number: from nothing to twice its value, as in live pages; the picture follows. */
function ParameterSlider({ pointer, name, value }: { readonly pointer: string; readonly name: string; readonly value: Json }): ReactElement | null {
  const match = NUMBER.exec(textOf(value));
  const now = Number(match?.[1] ?? NaN);
  const [middle, setMiddle] = useState(now);
  if (match === null || now === 0) return null;
  const ends = [0, 2 * middle].sort((one, other) => one - other) as [number, number];
  const inside = now >= ends[0] && now <= ends[1];
  const change = (next: number): void => { setValue(pointer, `${Number(next.toPrecision(4))}${match[2] === undefined ? "" : " deg"}`); };
  return (
    <input
      type="range" className="parameter-slider" aria-label={`Slider of ${name}`} min={0.02 * ends[1] || ends[0]} max={ends[1] || 0.02 * ends[0]} step="any" value={now}
      onPointerDown={() => { if (!inside) setMiddle(now); }} onChange={(event) => { change(Number(event.target.value)); }} onBlur={() => { setMiddle(now); endGesture(); }}
    />
  );
}

function Inputs(): ReactElement {
  const value = useStore((state) => state.data["inputs"]);
  const names = isArray(value) ? value.map(textOf) : [];
  const add = (): void => {
    endGesture();
    edit((data) => withValue(data, "/inputs", [...names, freeName("u1", symbolsOf(data))]));
    useStore.setState({ focusPointer: `/inputs/${names.length}` });
  };
  return (
    <FieldGroup label="Inputs" tip="Quantities given from outside during the motion, such as motor torques." problems={useProblems("/inputs")}>
      {names.map((name, index) => (
        <div className="map-head" key={index}>
          <NameInput pointer={`/inputs/${index}`} label={`Input ${index + 1}`} value={name} change={(text) => acceptName(`${INPUTS}/${index}`, text)} />
          <button type="button" className="icon-button" aria-label={`Remove ${name}`} onClick={() => { endGesture(); edit((data) => withValue(data, "/inputs", names.filter((_, place) => place !== index))); }}><Icon name="trash" size={14} /></button>
        </div>
      ))}
      <button type="button" className="button small" onClick={add}><Icon name="plus" size={14} /> Add an input</button>
    </FieldGroup>
  );
}
