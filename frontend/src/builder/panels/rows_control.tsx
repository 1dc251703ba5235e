/** Rows of formulas, as many as there are: matrices of a block, points of a table. */

import type { ReactElement } from "react";
import { textOf } from "../model/entries";
import { isArray, joinPointer } from "../model/pointers";
import { Icon } from "../shell/icons";
import { endGesture } from "../store";
import type { Json, JsonObject } from "../types";
import { FormulaInput, LiveInput, setValue } from "./inputs";

interface NamedProps {
  readonly pointer: string;
  readonly value: JsonObject;
  readonly names: readonly string[];
  readonly label: string;
}

/** Formulas under names that are given, such as the gains of a controller; what is empty is left out. */
export function NamedFormulas({ pointer, value, names, label }: NamedProps): ReactElement {
  // what else the file has is shown too, so that it can be taken out
  const all = [...names, ...Object.keys(value).filter((each) => !names.includes(each))];
  return (
    <div className="map">
      {all.map((name) => (
        <div className="named-row" key={name}>
          <span aria-hidden="true">{name}</span>
          <div><FormulaInput pointer={`${pointer}${joinPointer(name)}`} value={value[name]} label={`${label} ${name}`} placeholder="0" optional /></div>
        </div>
      ))}
    </div>
  );
}

interface RowsProps {
  readonly pointer: string;
  readonly value: Json | undefined;
  readonly label: string;
  /** Where all rows have so many entries. */
  readonly columns: number | null;
}

export function RowsControl({ pointer, value, label, columns }: RowsProps): ReactElement {
  const rows = isArray(value) ? value.map((row) => (isArray(row) ? row.map(textOf) : [textOf(row)])) : [];
  const width = columns ?? Math.max(1, ...rows.map((row) => row.length));
  const set = (next: readonly (readonly string[])[]): void => { setValue(pointer, next.length === 0 ? undefined : next); };
  const step = (next: readonly (readonly string[])[]): void => {
    endGesture();
    set(next);
  };
  const change = (place: number, column: number, text: string): void => {
    set(rows.map((row, index) => (index === place ? row.map((each, k) => (k === column ? text : each)) : row)));
  };
  return (
    <div className="map">
      {rows.map((row, index) => (
        <div className="rows-row" key={index}>
          {row.map((text, column) => <LiveInput key={column} pointer={`${pointer}/${index}/${column}`} label={`${label} ${index + 1}, ${column + 1}`} value={text} change={(next) => { change(index, column, next); }} />)}
          <button type="button" className="icon-button" aria-label={`Remove row ${index + 1} of ${label}`} title="Remove this row" onClick={() => { step(rows.filter((_, place) => place !== index)); }}><Icon name="trash" size={14} /></button>
        </div>
      ))}
      <div className="row">
        <button type="button" className="button small" data-pointer={pointer} onClick={() => { step([...rows, Array.from({ length: width }, () => "0")]); }}><Icon name="plus" size={14} /> Add a row</button>
        {columns === null && rows.length > 0 && <button type="button" className="button small" onClick={() => { step(rows.map((row) => [...row, "0"])); }}><Icon name="plus" size={14} /> Add a column</button>}
        {columns === null && width > 1 && <button type="button" className="button small" onClick={() => { step(rows.map((row) => row.slice(0, -1))); }}><Icon name="trash" size={14} /> Remove a column</button>}
      </div>
    </div>
  );
}
