/** A server that does not answer, and what to do. */

import type { ReactElement } from "react";
import { ABSENCES } from "../connection";
import { sentence } from "../panels/field_frame";
import { useStore } from "../store";
import { Icon } from "./icons";

export function ServerBar(): ReactElement | null {
  const server = useStore((state) => state.server);
  if (server === "here") return null;
  const { what, fix } = ABSENCES[server];
  return <div className="outside" role="alert" data-testid="server-bar"><Icon name="warning" size={16} /> <span><b>{sentence(what)}</b> {sentence(fix)}</span></div>;
}
