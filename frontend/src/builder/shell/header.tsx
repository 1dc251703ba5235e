/** The bar at the top: files, history, work, and what the mechanism is. */

import { useState, type ReactElement } from "react";
import { COMMANDS, giveCommand, printedKeys, type CommandName } from "../commands/all";
import { exportModel, EXPORTS } from "../commands/files";
import { MenuList, menuItem, type MenuItem } from "../diagram/popups";
import { isDirty, useHistory, useStore, type Layout, type Panel } from "../store";
import type { Problem, Severity, Summary } from "../types";
import { Icon } from "./icons";
import { useRoving } from "./roving";
import { nextTheme } from "./theme";

export function Header(): ReactElement {
  const { canUndo, canRedo } = useHistory();
  const roving = useRoving("button");
  return (
    <header className="topbar">
      <h1 className="hidden">Diagram editor</h1>
      <FileMenu />
      <Title />
      <div className="tools" role="toolbar" aria-label="Commands" {...roving}>
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
      <Layouts />
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
  return (
    <span className="split-button">
      <button type="button" className="tool go" title="Simulate (F5)" data-testid="simulate" onClick={() => { giveCommand("simulate"); }}><Icon name="play" /><span>Simulate</span></button>
      <Duration />
      <button type="button" className="tool go" aria-label="Simulate with other settings" title="Inputs, output step, solver" onClick={() => { useStore.setState({ dialog: "simulate" }); }}><Icon name="down" size={14} /></button>
    </span>
  );
}

/** How long the next simulation is, beside its button. */
function Duration(): ReactElement {
  const simulation = useStore((state) => state.simulation);
  const [text, setText] = useState<string | null>(null);
  const take = (typed: string): void => {
    const seconds = Number(typed);
    setText(typed);
    if (seconds > 0 && seconds <= 1e6) useStore.setState({ simulation: { ...simulation, t_end: seconds } }); // F5 takes it from here
  };
  return (
    <label className="tool go duration" title="Duration of the simulation">
      <input
        aria-label="Duration of the simulation in seconds" size={3} value={text ?? String(simulation.t_end)} aria-invalid={text !== null && Number(text) !== simulation.t_end}
        onChange={(event) => { take(event.target.value); }} onBlur={() => { setText(null); }} onKeyDown={(event) => { if (event.key === "Enter") setText(null); }}
      />
      <span aria-hidden="true">s</span>
    </label>
  );
}

const LAYOUTS: readonly (readonly [Layout, CommandName])[] = [["draw", "drawLayout"], ["watch", "watchLayout"], ["read", "readLayout"]];

/** What has the room of the window. */
function Layouts(): ReactElement {
  const layout = useStore((state) => state.layout);
  return (
    <div className="segments layouts" role="radiogroup" aria-label="Layout">
      {LAYOUTS.map(([name, command]) => (
        <button key={name} type="button" role="radio" aria-checked={layout === name} title={`${COMMANDS[command].title} (${printedKeys(COMMANDS[command].keys[0] ?? "")})`} onClick={() => { giveCommand(command); }}>
          {name.charAt(0).toUpperCase() + name.slice(1)}
        </button>
      ))}
    </div>
  );
}

const PANELS: readonly (readonly [Panel, string])[] = [["diagram", "Diagram"], ["picture", "Picture"], ["results", "Results"], ["left", "Palette"], ["right", "Properties"]];

/** In narrow windows: which panel is seen, or which side lies over the rest. */
export function Panels(): ReactElement {
  const panel = useStore((state) => state.panel);
  return (
    <nav className="panels" aria-label="Panels">
      {PANELS.map(([name, title]) => (
        <button key={name} type="button" className={`button small of-${name}`} aria-pressed={panel === name} onClick={() => { useStore.setState({ panel: panel === name ? "diagram" : name }); }}>{title}</button>
      ))}
    </nav>
  );
}

function Title(): ReactElement {
  const document = useStore((state) => state.document);
  const dirty = useStore(isDirty);
  return (
    <div className="doc-title">
      <b title={document?.path ?? "Not saved yet"}>{document?.name ?? ""}</b>
      {dirty && <span className="dirty" title="Unsaved changes" data-testid="dirty"> ●<span className="hidden">not saved</span></span>}
    </div>
  );
}

function FileMenu(): ReactElement {
  const [open, setOpen] = useState(false);
  const names: readonly (CommandName | null)[] = ["new", "start", "open", null, "save", "saveAs", null];
  const items: (MenuItem | null)[] = names.map((name) => (name === null ? null : menuItem(name, COMMANDS[name].title)));
  for (const [kind, title] of EXPORTS) items.push({ key: kind, text: `Export ${title}`, run: () => { void exportModel(kind); } });
  return (
    <div className="file-menu" onBlur={(event) => { if (!event.currentTarget.contains(event.relatedTarget)) setOpen(false); }}>
      <button type="button" className="tool brand" aria-haspopup="menu" aria-expanded={open} title="New, open, save, export" onClick={() => { setOpen(!open); }}><Icon name="menu" /><span>File</span></button>
      {open && <MenuList label="File" items={items} done={() => { setOpen(false); }} />}
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
    <div className={`live${fresh ? "" : " stale"}`} data-testid="live" role="group" aria-label="Summary of the mechanism">
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
  const { freedoms } = summary;
  return (
    <span className="counts">
      {freedoms !== null && <b title={`${plural(freedoms, "degree")} of freedom`}>{freedoms} <span className="long">degree{freedoms === 1 ? "" : "s"} of freedom</span><span className="short" aria-hidden="true">DOF</span></b>}
      <span>{plural(summary.coordinates.length, "coordinate")}</span>
      <span>{plural(summary.constraints, "constraint")}</span>
      {summary.unilateral > 0 && <span title="Of contacts, limits and ropes: they hold only while these are closed or taut">{summary.unilateral} unilateral</span>}
      {summary.redundant.length > 0 && <span className="warning">{summary.redundant.length} redundant</span>}
    </span>
  );
}
