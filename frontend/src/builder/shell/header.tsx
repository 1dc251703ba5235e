/** The bar at the top: files, history, work, and what the mechanism is. */

import { useState, type ReactElement } from "react";
import { COMMANDS, giveCommand, printedKeys, type CommandName } from "../commands/all";
import { exportModel, EXPORTS } from "../commands/files";
import { MenuList, menuItem, type MenuItem } from "../diagram/popups";
import { isDirty, useHistory, useStore } from "../store";
import type { Problem, Severity, Summary } from "../types";
import { Icon } from "./icons";
import { nextTheme } from "./theme";

export function Header(): ReactElement {
  const { canUndo, canRedo } = useHistory();
  return (
    <header className="topbar">
      <FileMenu />
      <Title />
      <div className="tools" role="toolbar" aria-label="Commands">
        <Tool name="undo" icon="undo" disabled={!canUndo} />
        <Tool name="redo" icon="redo" disabled={!canRedo} />
        <Tool name="save" icon="save" />
        <span className="bar" />
        <Tool name="insert" icon="plus" text="Add" />
        <Tool name="arrange" icon="arrange" />
        <span className="bar" />
        <Tool name="equations" icon="sum" text="Equations" />
        <SimulateButton />
      </div>
      <Live />
      <button type="button" className="tool" aria-label="Light, dark, high contrast" title="Light, dark, high contrast" onClick={nextTheme}><Icon name="theme" /></button>
      <Tool name="help" icon="help" />
    </header>
  );
}

function Tool({ name, icon, text = "", disabled = false }: { readonly name: CommandName; readonly icon: string; readonly text?: string; readonly disabled?: boolean }): ReactElement {
  const { title, keys } = COMMANDS[name];
  const hint = keys[0] === undefined ? title : `${title} (${printedKeys(keys[0])})`;
  return (
    <button type="button" className="tool" aria-label={title} title={hint} disabled={disabled} onClick={() => { giveCommand(name); }}>
      <Icon name={icon} />{text !== "" && <span>{text}</span>}
    </button>
  );
}

function SimulateButton(): ReactElement {
  const busy = useStore((state) => state.run !== null && (state.run.state === null || state.run.state.state === "running"));
  return (
    <span className="split-button">
      <button type="button" className="tool go" disabled={busy} title="Simulate (F5)" data-testid="simulate" onClick={() => { giveCommand("simulate"); }}><Icon name="play" /><span>Simulate</span></button>
      <button type="button" className="tool go" disabled={busy} aria-label="Simulate with other settings" title="Duration and inputs" onClick={() => { useStore.setState({ dialog: "simulate" }); }}><Icon name="down" size={14} /></button>
    </span>
  );
}

function Title(): ReactElement {
  const document = useStore((state) => state.document);
  const dirty = useStore(isDirty);
  return (
    <div className="doc-title">
      <b title={document?.path ?? "In no file yet"}>{document?.name ?? ""}</b>
      {dirty && <span className="dirty" title="Changes that are not saved" data-testid="dirty"> ●<span className="hidden">not saved</span></span>}
    </div>
  );
}

function FileMenu(): ReactElement {
  const [open, setOpen] = useState(false);
  const names: readonly (CommandName | null)[] = ["new", "start", "open", null, "save", "saveAs", null];
  const items: (MenuItem | null)[] = names.map((name) => (name === null ? null : menuItem(name, COMMANDS[name].title)));
  for (const [kind, title] of EXPORTS) items.push({ key: kind, text: `Write ${title}`, run: () => { void exportModel(kind); } });
  return (
    <div className="file-menu" onBlur={(event) => { if (!event.currentTarget.contains(event.relatedTarget)) setOpen(false); }}>
      <button type="button" className="tool brand" aria-haspopup="menu" aria-expanded={open} title="Files" onClick={() => { setOpen(!open); }}><Icon name="menu" /><span>symbody</span></button>
      {open && <MenuList label="Files" items={items} done={() => { setOpen(false); }} />}
    </div>
  );
}

function plural(count: number, word: string): string {
  return `${count} ${word}${count === 1 ? "" : "s"}`;
}

/** What the mechanism is now: freedoms, coordinates, constraints, problems. */
function Live(): ReactElement {
  const check = useStore((state) => state.check);
  const fresh = useStore((state) => state.checked === state.data);
  const reached = useStore((state) => state.server === "here");
  return (
    <div className={`live${fresh ? "" : " stale"}`} data-testid="live" role="group" aria-label="What the mechanism is">
      {check?.summary != null && countOf(check.problems, "error") === 0 && <Counts summary={check.summary} />}
      {!reached ? <StateButton worst="warning" text="Not connected" /> : check !== null && <StateOf problems={check.problems} />}
    </div>
  );
}

function countOf(problems: readonly Problem[], severity: Severity): number {
  return problems.filter((each) => each.severity === severity).length;
}

function StateOf({ problems }: { readonly problems: readonly Problem[] }): ReactElement {
  const [errors, warnings] = [countOf(problems, "error"), countOf(problems, "warning")];
  if (errors > 0) return <StateButton worst="error" text={plural(errors, "error")} />;
  return warnings > 0 ? <StateButton worst="warning" text={plural(warnings, "warning")} /> : <StateButton worst="check" text="Ready" />;
}

function StateButton({ worst, text }: { readonly worst: "error" | "warning" | "check"; readonly text: string }): ReactElement {
  return (
    <button type="button" className={`state ${worst === "check" ? "good" : worst}`} onClick={() => { useStore.setState({ tab: "problems" }); }}>
      <Icon name={worst} size={16} /> {text}
    </button>
  );
}

function Counts({ summary }: { readonly summary: Summary }): ReactElement {
  return (
    <span className="counts">
      {summary.freedoms !== null && <b>{plural(summary.freedoms, "freedom")}</b>}
      <span>{plural(summary.coordinates.length, "coordinate")}</span>
      <span>{plural(summary.constraints, "constraint")}</span>
      {summary.redundant.length > 0 && <span className="warning">{summary.redundant.length} redundant</span>}
    </span>
  );
}
