/** Directions: a letter, or the components of a vector. */

import type { ReactElement } from "react";
import { textOf } from "../model/entries";
import { isArray } from "../model/pointers";
import { endGesture } from "../store";
import type { Json } from "../types";
import { LiveInput, setValue, VectorInput } from "./inputs";

const LETTERS = ["x", "y", "z"] as const;

export function AxisControl({ pointer, value, label, change }: {
  readonly pointer: string; readonly value: Json; readonly label: string; readonly change?: (value: Json) => void;
}): ReactElement { // prettier-ignore
  const set = change ?? ((next: Json) => { setValue(pointer, next); });
  const vector = isArray(value);
  const components = (letter: Json): Json[] => LETTERS.map((each) => (each === letter ? "1" : "0"));
  return (
    <>
      <div className="segments" role="radiogroup" aria-label={label}>
        {LETTERS.map((letter) => (
          <button key={letter} type="button" role="radio" aria-checked={value === letter} data-pointer={pointer} onClick={() => { endGesture(); set(letter); }}>{letter}</button>
        ))}
        <button type="button" role="radio" aria-checked={vector} onClick={() => { endGesture(); if (!vector) set(components(value)); }}>vector</button>
      </div>
      {vector && change === undefined && <VectorInput pointer={pointer} value={value} labels={LETTERS} label={label} />}
      {vector && change !== undefined && <Components pointer={pointer} value={value} label={label} change={change} />}
    </>
  );
}

function Components({ pointer, value, label, change }: { readonly pointer: string; readonly value: readonly Json[]; readonly label: string; readonly change: (value: Json) => void }): ReactElement {
  return (
    <div className="vector three">
      {LETTERS.map((letter, index) => (
        <label key={letter}>
          <span aria-hidden="true">{letter}</span>
          <LiveInput
            pointer={`${pointer}/${index}`} label={`${label} ${letter}`} value={textOf(value[index])}
            change={(text) => { change(value.map((each, place) => (place === index ? text : each))); }}
          />
        </label>
      ))}
    </div>
  );
}

export function AxesControl({ pointer, value, count, label }: { readonly pointer: string; readonly value: Json; readonly count: number; readonly label: string }): ReactElement {
  const axes = Array.from({ length: count }, (_, index) => (isArray(value) ? (value[index] ?? "z") : "z"));
  return (
    <>
      {axes.map((axis, index) => (
        <AxisControl
          key={index} pointer={`${pointer}/${index}`} value={axis} label={`${label} ${index + 1}`}
          change={(next) => { setValue(pointer, axes.map((each, place) => (place === index ? next : each))); }}
        />
      ))}
    </>
  );
}

export function MatrixControl({ pointer, value, rows, columns, label }: {
  readonly pointer: string; readonly value: Json | undefined; readonly rows: number; readonly columns: number; readonly label: string;
}): ReactElement { // prettier-ignore
  if (!isArray(value)) {
    const unit = Array.from({ length: rows }, (_, row) => Array.from({ length: columns }, (_, column) => (row === column ? "1" : "0")));
    return <button type="button" className="button small" data-pointer={pointer} onClick={() => { endGesture(); setValue(pointer, unit); }}>Give a matrix</button>;
  }
  return (
    <>
      {value.map((row, index) => (
        <VectorInput key={index} pointer={`${pointer}/${index}`} value={isArray(row) ? row : []} label={`${label} row ${index + 1}`} labels={Array.from({ length: columns }, () => "")} />
      ))}
      <button type="button" className="button small" onClick={() => { endGesture(); setValue(pointer, undefined); }}>Remove</button>
    </>
  );
}
