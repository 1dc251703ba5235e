/** A list of objects of one or several types, such as the shapes of a body. */

import type { ReactElement } from "react";
import { leastEntry } from "../model/edit";
import { textOf } from "../model/entries";
import { labelOf } from "../model/fields";
import { isObject, joinPointer, withValue } from "../model/pointers";
import { choicesOf, typeOfNode, type SchemaNode } from "../model/schema";
import { Icon } from "../shell/icons";
import { edit, endGesture, useStore } from "../store";
import type { Json } from "../types";
import { setValue } from "./inputs";
import type { Nesting } from "./nesting";

interface EntriesProps extends Nesting {
  readonly pointer: string;
  readonly node: SchemaNode;
  readonly value: readonly Json[];
  readonly label: string;
}

export function EntriesControl({ pointer, node, value, label, Fields }: EntriesProps): ReactElement {
  const schema = useStore((state) => state.schema);
  if (schema === null) return <></>;
  const types = choicesOf(schema.schema, node);
  const add = (type: SchemaNode): void => {
    endGesture();
    setValue(pointer, [...value, leastEntry(schema.schema, type)]);
  };
  const remove = (index: number): void => {
    endGesture();
    const left = value.filter((_, place) => place !== index);
    edit((data) => withValue(data, pointer, left.length === 0 ? undefined : left));
  };
  return (
    <div className="map">
      {value.map((each, index) => {
        const type = types.find((one) => isObject(each) && typeOfNode(one) === textOf(each["type"])) ?? types[0]!;
        return (
          <details key={index} className="list-entry">
            <summary>{labelOf(typeOfNode(type))} <button type="button" className="icon-button" aria-label={`Remove ${label} ${index + 1}`} onClick={() => { remove(index); }}><Icon name="trash" size={14} /></button></summary>
            <div className="nested">{isObject(each) && <Fields node={type} pointer={`${pointer}${joinPointer(index)}`} value={each} />}</div>
          </details>
        );
      })}
      <select aria-label={`Add ${label}`} data-pointer={pointer} value="" onChange={(event) => { const type = types.find((one) => typeOfNode(one) === event.target.value); if (type !== undefined) add(type); }}>
        <option value="">Add {label.toLowerCase()}…</option>
        {types.map((one) => <option key={typeOfNode(one)} value={typeOfNode(one)}>{labelOf(typeOfNode(one))}</option>)}
      </select>
    </div>
  );
}
