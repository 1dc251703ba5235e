/** What a control that holds fields of its own is given to show them: forms nest, imports do not. */

import type { ComponentType } from "react";
import type { SchemaNode } from "../model/schema";
import type { JsonObject } from "../types";

export interface FieldsProps {
  readonly node: SchemaNode;
  readonly pointer: string;
  readonly value: JsonObject;
  readonly skip?: readonly string[];
}

/** Of a control with fields inside. */
export interface Nesting {
  /** Shows the fields of an object of the schema. */
  readonly Fields: ComponentType<FieldsProps>;
}
