/** The fields of a form, each by what the schema says of it. */

import type { ReactElement } from "react";
import { USUAL_LAW } from "../model/contacts";
import { allReferences, entriesOf, entryOfPointer, GROUND, textOf } from "../model/entries";
import { fieldsOf, type Acting, type Field as FieldOf, type FieldKind } from "../model/fields";
import { isArray, isObject, joinPointer } from "../model/pointers";
import { renameCoordinate } from "../model/rename";
import { acceptName, acceptSymbol } from "../rename_command";
import { endGesture, useStore } from "../store";
import type { Json } from "../types";
import { AxesControl, AxisControl, MatrixControl } from "./axis_control";
import { ShapesControl, VariantControl } from "./contact_controls";
import { EntriesControl } from "./entries_control";
import { FieldFrame, FieldGroup, useProblems } from "./field_frame";
import { Choice, FormulaInput, LiveInput, NameInput, setValue, VectorInput } from "./inputs";
import { GroupControl, JsonControl, LawControl, ListControl, MapControl, NamesControl } from "./nested";
import type { FieldsProps } from "./nesting";
import { NamedFormulas, RowsControl } from "./rows_control";
import { TreeControl } from "./tree_control";

export interface FieldProps {
  readonly field: FieldOf;
  readonly pointer: string;
  readonly value: Json | undefined;
}

/** Fields of one line with a label; all others are groups. */
const SINGLE = new Set(["name", "text", "formula", "choice", "names", "formulas", "json"]);

/** Return what the table at a pointer acts with where it is the drive of a joint. */
function actingOf(pointer: string): Acting {
  return (/^\/joint\/\d+\/(force|torque)(?:\/|$)/.exec(pointer)?.[1] ?? "") as Acting;
}

/** The fields of an object of the schema. */
export function Fields({ node, pointer, value, skip = [] }: FieldsProps): ReactElement {
  const schema = useStore((state) => state.schema);
  if (schema === null) return <></>;
  const fields = fieldsOf(schema.schema, node, actingOf(pointer)).filter((each) => !skip.includes(each.key));
  return <>{fields.map((field) => <Field key={field.key} field={field} pointer={`${pointer}${joinPointer(field.key)}`} value={value[field.key]} />)}</>;
}

export function Field(props: FieldProps): ReactElement {
  const { field, pointer } = props;
  const problems = useProblems(pointer, field.control.kind !== "group" && field.control.kind !== "map");
  const { label, unit, tip, control } = field;
  const wrong = problems.some((each) => each.severity === "error");
  if (control.kind === "switch") return <SwitchField {...props} />;
  if (SINGLE.has(control.kind) || (control.kind === "reference" && control.labels.length === 1)) {
    return (
      <FieldFrame label={label} unit={unit} tip={tip} problems={problems}>
        {(id, describedBy) => <SingleControl {...props} id={id} describedBy={describedBy} wrong={wrong} />}
      </FieldFrame>
    );
  }
  return <FieldGroup label={label} unit={unit} tip={tip} problems={problems}><GroupedControl {...props} /></FieldGroup>;
}

type ControlProps = FieldProps & { readonly id: string; readonly describedBy: string; readonly wrong: boolean };

function defaultText(value: Json): string {
  return typeof value === "string" || typeof value === "number" ? String(value) : "";
}

type Common = Omit<ControlProps, "field"> & { readonly placeholder: string };

/** Controls of one line, by kind. */
const SINGLE_CONTROLS: Partial<Record<FieldKind["kind"], (common: Common, field: FieldOf) => ReactElement>> = {
  name: ({ value, ...rest }) => <NameInput {...rest} value={textOf(value)} change={(text) => acceptName(entryOfPointer(rest.pointer) ?? "", text)} />,
  text: ({ value, ...rest }, { key }) => <SymbolInput {...rest} value={textOf(value)} coordinate={key === "coordinate"} />,
  choice: (common, field) => <ValueChoice common={common} field={field} />,
  names: (common, { key }) => <NamesControl {...common} of={key} />,
  reference: ({ value, ...rest }, { control, default: usual }) => <ReferenceChoice {...rest} value={textOf(value ?? usual)} of={control.kind === "reference" ? control.of : "frame"} />,
  formulas: (common) => <FormulasControl {...common} />,
  formula: (common, { required, unit }) => <FormulaInput {...common} unit={unit} optional={!required} />,
};

function SingleControl({ field, ...rest }: ControlProps): ReactElement {
  const common = { ...rest, placeholder: defaultText(field.default) };
  return SINGLE_CONTROLS[field.control.kind]?.(common, field) ?? <JsonControl {...common} />;
}

function ValueChoice({ common, field }: { readonly common: Common; readonly field: FieldOf }): ReactElement {
  const { pointer, value } = common;
  const options = field.control.kind === "choice" ? field.control.values.map((each) => ({ value: each, text: each })) : [];
  const all = field.required || field.default !== null ? options : [{ value: "", text: "—" }, ...options];
  return <Choice {...common} value={textOf(value ?? field.default)} options={all} change={(next) => { setValue(pointer, next === "" ? undefined : next); }} />;
}

/** A name of something in the model; a coordinate takes its initial values with it. */
function SymbolInput({ coordinate, value, ...rest }: Omit<ControlProps, "field" | "value"> & { readonly value: string; readonly coordinate: boolean; readonly placeholder: string }): ReactElement {
  const change = (text: string): string => {
    if (coordinate && value !== "" && text !== "") return acceptSymbol(value, text, renameCoordinate);
    endGesture();
    setValue(rest.pointer, text === "" ? undefined : text);
    return "";
  };
  return <NameInput {...rest} value={value} change={change} placeholder={rest.placeholder === "" ? "automatic" : rest.placeholder} />;
}

/** One formula, or several with semicolons between them. */
function FormulasControl({ value, ...rest }: Omit<ControlProps, "field">): ReactElement {
  const text = isArray(value) ? value.map(textOf).join("; ") : textOf(value);
  const change = (next: string): void => { setValue(rest.pointer, next.includes(";") ? next.split(";").map((each) => each.trim()) : next); };
  return <LiveInput {...rest} value={text} change={change} />;
}

function ReferenceChoice({ of, value, pointer, ...rest }: { readonly of: "frame" | "body" | "coordinate"; readonly value: string; readonly pointer: string; readonly id?: string; readonly describedBy?: string; readonly label?: string }): ReactElement {
  const data = useStore((state) => state.data);
  const coordinates = useStore((state) => state.check?.summary?.coordinates);
  const bodies = [GROUND, ...entriesOf(data).filter((each) => each.section === "body").map((each) => each.name)];
  const all = of === "frame" ? allReferences(data) : of === "body" ? bodies : (coordinates ?? []);
  return <Choice {...rest} pointer={pointer} value={value} options={all.map((each) => ({ value: each, text: each }))} change={(next) => { setValue(pointer, next); }} />;
}

function ReferencesControl({ field, pointer, value }: FieldProps): ReactElement {
  const { control } = field;
  if (control.kind !== "reference") return <></>;
  const list = isArray(value) ? value.map(textOf) : [];
  return (
    <div className="references">
      {control.labels.map((label, index) => (
        <label key={label}>
          <span>{label}</span>
          <ReferencePart of={control.of} pointer={pointer} list={list} index={index} label={`${field.label} ${label}`} />
        </label>
      ))}
    </div>
  );
}

function ReferencePart({ of, pointer, list, index, label }: { readonly of: "frame" | "body" | "coordinate"; readonly pointer: string; readonly list: readonly string[]; readonly index: number; readonly label: string }): ReactElement {
  const data = useStore((state) => state.data);
  const coordinates = useStore((state) => state.check?.summary?.coordinates);
  const all = of === "coordinate" ? (coordinates ?? []) : allReferences(data);
  const change = (next: string): void => {
    const items = [...list];
    items[index] = next;
    setValue(pointer, items);
  };
  return <Choice pointer={`${pointer}/${index}`} label={label} value={list[index] ?? ""} options={all.map((each) => ({ value: each, text: each }))} change={change} />;
}

/** Controls of several lines, by kind. */
const GROUPED_CONTROLS: { readonly [K in FieldKind["kind"]]?: (props: FieldProps, control: Extract<FieldKind, { kind: K }>) => ReactElement } = {
  vector: ({ field, pointer, value }, { labels }) => {
    const usual = isArray(field.default) ? field.default : [];
    const mayLack = !field.required && field.default === null;
    return <VectorInput pointer={pointer} value={isArray(value) ? value : usual} labels={labels} label={field.label} unit={field.unit} fill={mayLack ? "" : "0"} />;
  },
  axis: ({ field, pointer, value }) => <AxisControl pointer={pointer} value={value ?? field.default} label={field.label} />,
  axes: ({ field, pointer, value }, { count }) => <AxesControl pointer={pointer} value={value ?? field.default} count={count} label={field.label} />,
  matrix: ({ field, pointer, value }, { rows, columns }) => <MatrixControl pointer={pointer} value={value} rows={rows} columns={columns} label={field.label} />,
  rows: ({ field, pointer, value }, { columns }) => <RowsControl pointer={pointer} value={value} columns={columns} label={field.label} />,
  tree: ({ pointer }) => <TreeControl pointer={pointer} />,
  reference: (props) => <ReferencesControl {...props} />,
  group: ({ field, pointer, value }, { node }) => <GroupControl pointer={pointer} node={node} value={isObject(value) ? value : null} label={field.label} Fields={Fields} />,
  map: ({ field, pointer, value }, { node, names }) => names.length > 0 ? <NamedFormulas pointer={pointer} value={isObject(value) ? value : {}} names={names} label={field.label} /> : <MapControl pointer={pointer} node={node} value={isObject(value) ? value : {}} field={field} Fields={Fields} />,
  entries: ({ field, pointer, value }, { node }) => <EntriesControl pointer={pointer} node={node} value={isArray(value) ? value : []} label={field.label} Fields={Fields} />,
  list: ({ field, pointer, value }) => <ListControl pointer={pointer} value={isArray(value) ? value : []} label={field.label} />,
  shapes: ({ field, pointer, value }, { kinds }) => <ShapesControl pointer={pointer} value={isArray(value) ? value : []} kinds={kinds} label={field.label} />,
  variant: ({ field, pointer, value }, { words, node }) => <VariantControl pointer={pointer} value={value} words={words} node={node} usual={USUAL_LAW} label={field.label} Fields={Fields} />,
  law: ({ field, pointer, value }, { curve }) => <LawControl pointer={pointer} value={value} curve={curve} label={field.label} Fields={Fields} />,
};

function GroupedControl(props: FieldProps): ReactElement {
  const { control } = props.field;
  const make = GROUPED_CONTROLS[control.kind] as ((props: FieldProps, control: FieldKind) => ReactElement) | undefined;
  return make?.(props, control) ?? <></>;
}

function SwitchField({ field, pointer, value }: FieldProps): ReactElement {
  const problems = useProblems(pointer);
  const on = (value ?? field.default) === true;
  return (
    <FieldFrame label={field.label} tip={field.tip} problems={problems}>
      {(id, describedBy) => (
        <input
          id={id} type="checkbox" className="switch" data-pointer={pointer} checked={on} aria-describedby={describedBy}
          onChange={() => { endGesture(); setValue(pointer, !on === field.default ? undefined : !on); }}
        />
      )}
    </FieldFrame>
  );
}
