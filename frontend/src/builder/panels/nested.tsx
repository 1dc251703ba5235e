/** Fields that hold further fields: drives, frames, turns, curves. */

import { useState, type ReactElement } from "react";
import { removeFrame } from "../model/edit";
import { entryOfPointer, FRAME_NAMES, freeName, textOf } from "../model/entries";
import { labelOf, type Field as FieldOf } from "../model/fields";
import { isArray, isObject, joinPointer, valueAt, withKey, withValue } from "../model/pointers";
import { isFormula, type SchemaNode } from "../model/schema";
import { renameCoordinate } from "../model/rename";
import { acceptFrameName, acceptKey, acceptSymbol } from "../rename_command";
import { Icon } from "../shell/icons";
import { edit, endGesture, useStore } from "../store";
import type { Json, JsonObject } from "../types";
import { AxisControl } from "./axis_control";
import { useProblems } from "./field_frame";
import { FormulaInput, LiveInput, NameInput, setValue, type InputProps } from "./inputs";
import type { Nesting } from "./nesting";

interface GroupProps extends Nesting {
  readonly pointer: string;
  readonly node: SchemaNode;
  readonly value: JsonObject | null;
  readonly label: string;
}

export function GroupControl({ pointer, node, value, label, Fields }: GroupProps): ReactElement {
  const set = (next: Json | undefined): void => {
    endGesture();
    setValue(pointer, next);
  };
  if (value === null) {
    return <button type="button" className="button small" data-pointer={pointer} onClick={() => { set({}); }}><Icon name="plus" size={14} /> Add {label.toLowerCase()}</button>;
  }
  return (
    <div className="nested">
      <Fields node={node} pointer={pointer} value={value} />
      <button type="button" className="button small" onClick={() => { set(undefined); }}><Icon name="trash" size={14} /> Remove {label.toLowerCase()}</button>
    </div>
  );
}

interface MapProps extends Nesting {
  readonly pointer: string;
  readonly node: SchemaNode;
  readonly value: JsonObject;
  readonly field: FieldOf;
}

/** Entries with names: frames of a body, drives by coordinate. */
export function MapControl({ pointer, node, value, field, Fields }: MapProps): ReactElement {
  const frames = field.key === "frames";
  const coordinates = useStore((state) => state.check?.summary?.coordinates);
  const add = (): void => {
    const taken = new Set(Object.keys(value));
    const likely = frames ? FRAME_NAMES : (coordinates ?? []);
    const name = likely.find((each) => !taken.has(each)) ?? freeName(`${field.key}1`, taken);
    endGesture();
    setValue(`${pointer}${joinPointer(name)}`, isFormula(node) ? "0" : frames ? { at: ["0", "0", "0"] } : {});
  };
  return (
    <div className="map">
      {Object.entries(value).map(([key, each], index) => <MapRow key={index} name={key} each={each} pointer={pointer} node={node} frames={frames} Fields={Fields} />)}
      <button type="button" className="button small" data-pointer={pointer} onClick={add}><Icon name="plus" size={14} /> Add {frames ? "a frame" : labelOf(field.key).toLowerCase()}</button>
    </div>
  );
}

interface RowProps extends Nesting {
  readonly name: string;
  readonly each: Json;
  readonly pointer: string;
  readonly node: SchemaNode;
  readonly frames: boolean;
}

function renameRow({ name, each, pointer, frames }: RowProps, text: string): string {
  if (frames) return acceptFrameName(entryOfPointer(pointer) ?? "", name, text);
  if (!isObject(each)) return acceptSymbol(name, text, renameCoordinate);
  return acceptKey(valueAt(useStore.getState().data, pointer), name, text, (data, before, after) => withKey(data, pointer, before, after));
}

function removeRow({ name, pointer, frames }: RowProps): void {
  endGesture();
  edit((data) => (frames ? removeFrame(data, entryOfPointer(pointer) ?? "", name) : withValue(data, `${pointer}${joinPointer(name)}`, undefined)));
}

function MapRow(props: RowProps): ReactElement {
  const { name, each, pointer, node, frames, Fields } = props;
  const own = `${pointer}${joinPointer(name)}`;
  const wrong = useProblems(own).length > 0;
  const [open, setOpen] = useState(!frames || wrong);
  const object = isObject(each) ? each : null;
  return (
    <div className={`map-row${open ? " open" : ""}`}>
      <RowHead {...props} open={open} setOpen={setOpen} />
      {open && object !== null && <div className="nested"><Fields node={node} pointer={own} value={object} /></div>}
    </div>
  );
}

function RowHead(props: RowProps & { readonly open: boolean; readonly setOpen: (open: boolean) => void }): ReactElement {
  const { name, each, pointer, node, frames, open, setOpen } = props;
  const own = `${pointer}${joinPointer(name)}`;
  return (
    <div className="map-head">
      {frames && <button type="button" className="icon-button" aria-expanded={open} aria-label={`Frame ${name}`} onClick={() => { setOpen(!open); }}><Icon name={open ? "down" : "right"} size={14} /></button>}
      <NameInput pointer={`${own}#name`} label={`Name of ${name}`} value={name} change={(text) => renameRow(props, text)} />
      {frames && isObject(each) && !open && <FramePlace pointer={own} value={each} name={name} />}
      {isFormula(node) && <FormulaInput pointer={own} value={each} label={name} />}
      <button type="button" className="icon-button" aria-label={`Remove ${name}`} title={`Remove ${name}`} onClick={() => { removeRow(props); }}><Icon name="trash" size={14} /></button>
    </div>
  );
}

/** Where a frame is, on the line of its name. */
function FramePlace({ pointer, value, name }: { readonly pointer: string; readonly value: JsonObject; readonly name: string }): ReactElement {
  const at = value["at"];
  const texts = ["0", "1", "2"].map((_, index) => (isArray(at) ? textOf(at[index]) : "0"));
  return (
    <div className="frame-place">
      {texts.map((text, index) => (
        <LiveInput
          key={index} pointer={`${pointer}/at/${index}`} label={`${name} at ${"xyz".charAt(index)}`} value={text}
          change={(next) => { setValue(`${pointer}/at`, texts.map((each, place) => (place === index ? next : each))); }}
        />
      ))}
    </div>
  );
}

/** Successive turns of a frame. */
export function ListControl({ pointer, value, label }: { readonly pointer: string; readonly value: readonly Json[]; readonly label: string }): ReactElement {
  const set = (next: readonly Json[]): void => { setValue(pointer, next.length === 0 ? undefined : next); };
  return (
    <div className="turns">
      {value.map((turn, index) => {
        const [axis = "z", angle = "0"] = isArray(turn) ? turn : [];
        const change = (next: readonly Json[]): void => { set(value.map((each, place) => (place === index ? next : each))); };
        return (
          <div className="turn" key={index}>
            <AxisControl pointer={`${pointer}/${index}/0`} value={axis} label={`${label} ${index + 1} axis`} change={(next) => { change([next, angle]); }} />
            <LiveInput pointer={`${pointer}/${index}/1`} label={`${label} ${index + 1} angle`} value={textOf(angle)} change={(next) => { change([axis, next]); }} />
            <button type="button" className="icon-button" aria-label={`Remove turn ${index + 1}`} onClick={() => { endGesture(); set(value.filter((_, place) => place !== index)); }}><Icon name="trash" size={14} /></button>
          </div>
        );
      })}
      <button type="button" className="button small" data-pointer={pointer} onClick={() => { endGesture(); set([...value, ["z", "90 deg"]]); }}><Icon name="plus" size={14} /> Add a turn</button>
    </div>
  );
}

interface LawProps extends Nesting {
  readonly pointer: string;
  readonly value: Json | undefined;
  readonly curve: SchemaNode;
  readonly label: string;
}

/** A formula, or a curve through points. */
export function LawControl({ pointer, value, curve, label, Fields }: LawProps): ReactElement {
  const table = isObject(value);
  const choose = (next: Json | undefined): void => {
    endGesture();
    setValue(pointer, next);
  };
  return (
    <>
      <div className="segments" role="radiogroup" aria-label={label}>
        <button type="button" role="radio" aria-checked={!table} onClick={() => { if (table) choose(undefined); }}>formula</button>
        <button type="button" role="radio" aria-checked={table} onClick={() => { if (!table) choose({ x: ["0", "1"], y: ["0", "0"] }); }}>curve</button>
      </div>
      {table ? <div className="nested"><Fields node={curve} pointer={pointer} value={value} /></div> : <FormulaInput pointer={pointer} value={value} label={label} placeholder="0" optional />}
    </>
  );
}

/** Names with commas between them. */
export function NamesControl({ value, of, ...rest }: InputProps & { readonly value: Json | undefined; readonly of: string }): ReactElement {
  const names = isArray(value) ? value.map(textOf) : [];
  const change = (text: string): string => {
    const next = text.split(",").map((each) => each.trim()).filter((each) => each !== "");
    const one = names.length === next.length ? names.findIndex((each, index) => each !== next[index]) : -1;
    const single = one >= 0 && names.every((each, index) => index === one || each === next[index]);
    if (of === "coordinates" && single) return acceptSymbol(names[one]!, next[one]!, renameCoordinate);
    endGesture();
    setValue(rest.pointer, next.length === 0 ? undefined : next);
    return "";
  };
  return <NameInput {...rest} value={names.join(", ")} change={change} placeholder="automatic" />;
}

/** What has no control of its own, as JSON. */
export function JsonControl({ value, ...rest }: InputProps & { readonly value: Json | undefined }): ReactElement {
  const change = (text: string): string => {
    endGesture();
    try {
      setValue(rest.pointer, text === "" ? undefined : (JSON.parse(text) as Json));
    } catch {
      setValue(rest.pointer, text); // the check says what is wrong
    }
    return "";
  };
  return <NameInput {...rest} value={value === undefined ? "" : JSON.stringify(value)} change={change} />;
}
