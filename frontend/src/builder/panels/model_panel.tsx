/** The model's own properties: name, gravity, parameters, inputs, initial values. */

import { useId, type ReactElement } from "react";
import { expectChanges } from "../checking";
import { freeName, INPUTS, symbolsOf, textOf } from "../model/entries";
import { isArray, isObject, joinPointer, valueAt, withValue } from "../model/pointers";
import { renameInitial, renameParameter } from "../model/rename";
import { Icon } from "../shell/icons";
import { acceptName } from "../rename_command";
import { edit, endGesture, useStore } from "../store";
import type { Json, Model } from "../types";
import { FieldFrame, FieldGroup, ProblemLines, useProblems } from "./field_frame";
import { FormulaInput, LiveInput, NameInput, setValue, VectorInput } from "./inputs";

export function ModelPanel(): ReactElement {
  const data = useStore((state) => state.data);
  const gravity = valueAt(data, "/gravity");
  return (
    <div className="pad form">
      <header className="form-head"><Icon name="file" size={20} /><h2>Model</h2></header>
      <FieldFrame label="Name" problems={useProblems("/name")}>
        {(id, describedBy) => <LiveInput pointer="/name" id={id} describedBy={describedBy} value={textOf(data["name"])} change={(text) => { setValue("/name", text === "" ? undefined : text); }} />}
      </FieldFrame>
      <FieldGroup label="Gravity" unit="m/s²" tip="Acceleration of free fall, in the axes of the ground." problems={useProblems("/gravity")}>
        <VectorInput pointer="/gravity" value={isArray(gravity) ? gravity : []} labels={["x", "y", "z"]} label="Gravity" />
        {gravity === undefined && <GravityButtons />}
      </FieldGroup>
      <Table section="parameters" title="Parameters" tip="Values, or formulas of other parameters." unnamed="p1" rename={renameOfParameter} />
      <Inputs />
      <Table section="initial" title="Initial values" tip="Of coordinates and speeds; what is left out starts at zero, or where the loops close." unnamed="" rename={renameInitial} />
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

function renameOfParameter(data: Model, before: string, after: string): Model {
  const { schema } = useStore.getState();
  return schema === null ? data : renameParameter(schema.schema, data, before, after);
}

interface TableProps {
  readonly section: "parameters" | "initial";
  readonly title: string;
  readonly tip: string;
  /** What a new row is called; nothing where names are those of coordinates. */
  readonly unnamed: string;
  readonly rename: (data: Model, before: string, after: string) => Model;
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
  const change = (text: string): void => {
    if (text === "" || isTaken(section, text)) return;
    endGesture();
    edit((data) => rename(data, name, text));
  };
  return (
    <div className="table-row">
      <NameInput pointer={`${pointer}#name`} label={`Name of ${name}`} value={name} change={change} list={section === "initial" ? list : ""} />
      <span aria-hidden="true">=</span>
      <div><FormulaInput pointer={isObject(value) ? `${pointer}/value` : pointer} value={isObject(value) ? value["value"] : value} label={name} wrong={problems.some((each) => each.severity === "error")} /></div>
      <button type="button" className="icon-button" aria-label={`Remove ${name}`} title={`Remove ${name}`} onClick={() => { endGesture(); edit((data) => withValue(data, pointer, undefined)); }}><Icon name="trash" size={14} /></button>
      <ProblemLines problems={problems} />
    </div>
  );
}

function isTaken(section: string, name: string): boolean {
  return valueAt(useStore.getState().data, `/${section}${joinPointer(name)}`) !== undefined;
}

function Inputs(): ReactElement {
  const value = useStore((state) => state.data["inputs"]);
  const names = isArray(value) ? value.map(textOf) : [];
  const change = (index: number, text: string): void => {
    acceptName(`${INPUTS}/${index}`, text);
  };
  const add = (): void => {
    endGesture();
    edit((data) => withValue(data, "/inputs", [...names, freeName("u1", symbolsOf(data))]));
    useStore.setState({ focusPointer: `/inputs/${names.length}` });
  };
  return (
    <FieldGroup label="Inputs" tip="Quantities given from outside while it moves, such as motor torques." problems={useProblems("/inputs")}>
      {names.map((name, index) => (
        <div className="map-head" key={index}>
          <NameInput pointer={`/inputs/${index}`} label={`Input ${index + 1}`} value={name} change={(text) => { change(index, text); }} />
          <button type="button" className="icon-button" aria-label={`Remove ${name}`} onClick={() => { endGesture(); edit((data) => withValue(data, "/inputs", names.filter((_, place) => place !== index))); }}><Icon name="trash" size={14} /></button>
        </div>
      ))}
      <button type="button" className="button small" onClick={add}><Icon name="plus" size={14} /> Add an input</button>
    </FieldGroup>
  );
}
