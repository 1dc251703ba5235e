/** Fields of contacts: what touches, and the force along the normal. */

import type { ReactElement } from "react";
import { textOf } from "../model/entries";
import type { ShapeKind } from "../model/fields";
import { isArray, isObject } from "../model/pointers";
import type { SchemaNode } from "../model/schema";
import { endGesture } from "../store";
import type { Json, JsonObject } from "../types";
import { Choice, FormulaInput, setValue, VectorInput } from "./inputs";
import type { Nesting } from "./nesting";

function set(pointer: string, value: Json): void {
  endGesture();
  setValue(pointer, value);
}

interface ShapesProps {
  readonly pointer: string;
  readonly value: readonly Json[];
  readonly kinds: readonly ShapeKind[];
  readonly label: string;
}

/** The shape on start and that on end, each by its kind and its sizes. */
export function ShapesControl({ pointer, value, kinds, label }: ShapesProps): ReactElement {
  return (
    <div className="shapes">
      {["start", "end"].map((side, index) => (
        <ShapeControl key={side} pointer={`${pointer}/${index}`} shape={value[index]} kinds={kinds} label={`${label} on ${side}`} title={`On ${side}`} />
      ))}
    </div>
  );
}

/** Return the word of a shape. */
function wordOf(shape: Json | undefined): string {
  return isObject(shape) ? (Object.keys(shape)[0] ?? "") : textOf(shape);
}

/** Return a shape of a kind, with the first sizes of the one before where it had some. */
function newShape({ word, sizes }: ShapeKind, before: Json | undefined): Json {
  if (sizes.length === 0) return word;
  const old = isObject(before) ? Object.values(before).flat() : [];
  const all = sizes.map((_, index) => old[index] ?? "0.1");
  return { [word]: all.length === 1 ? all[0]! : all };
}

function ShapeControl({ pointer, shape, kinds, label, title }: { readonly pointer: string; readonly shape: Json | undefined; readonly kinds: readonly ShapeKind[]; readonly label: string; readonly title: string }): ReactElement {
  const word = wordOf(shape);
  const kind = kinds.find((each) => each.word === word);
  const choose = (next: string): void => {
    const chosen = kinds.find((each) => each.word === next);
    if (chosen !== undefined) set(pointer, newShape(chosen, shape));
  };
  const own = `${pointer}/${word}`;
  const sizes = isObject(shape) ? shape[word] : undefined;
  return (
    <div className="shape">
      <label>
        <span>{title}</span>
        <Choice pointer={pointer} label={label} value={word} options={kinds.map((each) => ({ value: each.word, text: each.word }))} change={choose} />
      </label>
      {kind?.sizes.length === 1 && (
        <label>
          <span>{kind.sizes[0]}</span>
          <FormulaInput pointer={own} value={sizes} label={`${label}, ${kind.sizes[0]!}`} />
        </label>
      )}
      {kind !== undefined && kind.sizes.length > 1 && <VectorInput pointer={own} value={isArray(sizes) ? sizes : []} labels={kind.sizes} label={`${label},`} />}
    </div>
  );
}

interface VariantProps extends Nesting {
  readonly pointer: string;
  readonly value: Json | undefined;
  readonly words: readonly string[];
  readonly node: SchemaNode;
  readonly usual: JsonObject;
  readonly label: string;
}

/** One of some words, or a table with fields of its own. */
export function VariantControl({ pointer, value, words, node, usual, label, Fields }: VariantProps): ReactElement {
  const table = isObject(value);
  return (
    <>
      <div className="segments" role="radiogroup" aria-label={label} data-pointer={pointer}>
        <button type="button" role="radio" aria-checked={table} onClick={() => { if (!table) set(pointer, usual); }}>force law</button>
        {words.map((word) => (
          <button key={word} type="button" role="radio" aria-checked={value === word} onClick={() => { if (value !== word) set(pointer, word); }}>{word}</button>
        ))}
      </div>
      {table && <div className="nested"><Fields node={node} pointer={pointer} value={value} /></div>}
    </>
  );
}
