/** The page as a whole. */

import { useEffect, type DragEvent, type ReactElement } from "react";
import { openFile, reloadFile, save } from "./commands/files";
import { Diagram } from "./diagram/diagram";
import { Popups } from "./diagram/popups";
import { OpenDialog, SaveDialog } from "./dialogs/files";
import { HelpDialog } from "./dialogs/help";
import { SimulateDialog } from "./dialogs/simulate";
import { StartScreen } from "./dialogs/start";
import { Palette } from "./panels/palette";
import { Problems, useAllProblems } from "./panels/problems";
import { Properties } from "./panels/properties";
import { Trees } from "./panels/trees";
import { Curves } from "./picture/curves";
import { Picture } from "./picture/picture";
import { Positions } from "./picture/positions";
import { Analyses } from "./results/analyses";
import { Equations } from "./results/equations";
import { Progress } from "./results/progress";
import { useFocusPointer } from "./shell/focus";
import { Header } from "./shell/header";
import { Icon } from "./shell/icons";
import { ServerBar } from "./shell/server_bar";
import { Splitter, useSizes } from "./shell/split";
import { useTheme } from "./shell/theme";
import { isDirty, useStore, type LeftTab, type Tab } from "./store";

export function App(): ReactElement {
  useTheme();
  useTitle();
  useFocusPointer();
  const hasDocument = useStore((state) => state.document !== null);
  const dialog = useStore((state) => state.dialog);
  return (
    <div className="page" onDragOver={(event) => { event.preventDefault(); }} onDrop={dropFile}>
      {hasDocument && dialog !== "start" ? <Editor /> : <StartScreen />}
      {dialog === "open" && <OpenDialog />}
      {dialog === "saveAs" && <SaveDialog />}
      {dialog === "help" && <HelpDialog />}
      {dialog === "simulate" && <SimulateDialog />}
      <Popups />
      <Spoken />
    </div>
  );
}

function dropFile(event: DragEvent): void {
  const [file] = event.dataTransfer.files;
  if (file === undefined) return;
  event.preventDefault();
  void openFile(file);
}

function useTitle(): void {
  const name = useStore((state) => state.document?.name ?? "");
  const dirty = useStore(isDirty);
  useEffect(() => { document.title = name === "" ? "symbody" : `${dirty ? "● " : ""}${name} · symbody`; }, [name, dirty]);
}

/** What screen readers are told. */
function Spoken(): ReactElement {
  const spoken = useStore((state) => state.spoken);
  return <div className="hidden" role="status" aria-live="polite">{spoken}</div>;
}

function Editor(): ReactElement {
  const [sizes, change, style] = useSizes();
  const wide = useStore((state) => state.wide);
  const id = useStore((state) => state.document?.id);
  return (
    <div className={`editor${wide ? " wide" : ""}`} style={style}>
      <Header />
      <div className="bars"><ServerBar /><OutsideBar /></div>
      <div className="columns">
        <LeftSide />
        <Splitter name="left" label="Width of the left side" upright sizes={sizes} change={change} />
        <main className="middle">
          {!wide && <Diagram />}
          {!wide && <Splitter name="lower" label="Height of the lower panels" upright={false} sizes={sizes} change={change} />}
          <div className="lower">
            <Picture key={id} />
            <Splitter name="picture" label="Width of the picture" upright sizes={sizes} change={change} />
            <LowerTabs />
          </div>
          <Progress />
        </main>
        <Splitter name="right" label="Width of the properties" upright sizes={sizes} change={change} />
        <Properties />
      </div>
    </div>
  );
}

/** The file was changed by another program. */
function OutsideBar(): ReactElement | null {
  const outside = useStore((state) => state.outside);
  if (!outside) return null;
  return (
    <div className="outside" role="alert">
      <Icon name="warning" size={16} /> The file was changed by another program.
      <button type="button" className="button small" onClick={() => { void reloadFile(); }}>Read it again</button>
      <button type="button" className="button small" onClick={() => { void save(true); }}>Overwrite it</button>
      <button type="button" className="button small" onClick={() => { useStore.setState({ dialog: "saveAs" }); }}>Save as…</button>
    </div>
  );
}

const LEFT: readonly (readonly [LeftTab, string])[] = [["palette", "Palette"], ["trees", "Trees"]];

function LeftSide(): ReactElement {
  const tab = useStore((state) => state.leftTab);
  return (
    <aside className="left" aria-label="Palette and trees">
      <div className="tabs"><div role="tablist" aria-label="Left side">
        {LEFT.map(([name, title]) => <button key={name} type="button" role="tab" aria-selected={tab === name} onClick={() => { useStore.setState({ leftTab: name }); }}>{title}</button>)}
      </div></div>
      {tab === "palette" ? <Palette /> : <Trees />}
    </aside>
  );
}

const LOWER: readonly (readonly [Tab, string])[] = [
  ["positions", "Positions"], ["curves", "Curves"], ["equations", "Equations"], ["analyses", "Analyses"], ["problems", "Problems"],
];

function LowerTabs(): ReactElement {
  const tab = useStore((state) => state.tab);
  const wide = useStore((state) => state.wide);
  const count = useAllProblems().length;
  return (
    <section className="panel" aria-label="Results">
      <div className="tabs">
        <div role="tablist" aria-label="Results">{LOWER.map(([name, title]) => (
          <button key={name} type="button" role="tab" aria-selected={tab === name} onClick={() => { useStore.setState({ tab: name }); }}>
            {title}{name === "problems" && count > 0 && <span className="count">{count}</span>}
          </button>
        ))}</div>
        <button type="button" className="icon-button end" aria-pressed={wide} aria-label="Give results and picture the whole height" title="Give results and picture the whole height" onClick={() => { useStore.setState({ wide: !wide }); }}><Icon name="wide" size={15} /></button>
      </div>
      <div className="tab-body" role="tabpanel" aria-label={LOWER.find(([name]) => name === tab)?.[1]}>
        {tab === "positions" && <Positions />}
        {tab === "curves" && <Curves />}
        {tab === "equations" && <Equations />}
        {tab === "analyses" && <Analyses />}
        {tab === "problems" && <Problems />}
      </div>
    </section>
  );
}
