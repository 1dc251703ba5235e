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
import { isFault, Notes, Problems, useAllProblems } from "./panels/problems";
import { Properties } from "./panels/properties";
import { Trees } from "./panels/trees";
import { Curves } from "./picture/curves";
import { Picture } from "./picture/picture";
import { Positions } from "./picture/positions";
import { Analyses } from "./results/analyses";
import { Equations } from "./results/equations";
import { Progress } from "./results/progress";
import { useFocusPointer } from "./shell/focus";
import { Header, Panels } from "./shell/header";
import { Icon } from "./shell/icons";
import { useRoving } from "./shell/roving";
import { ServerBar } from "./shell/server_bar";
import { Splitter, useSizes } from "./shell/split";
import { useTheme } from "./shell/theme";
import { isDirty, useStore, type LeftTab, type Panel, type Tab } from "./store";

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
  const layout = useStore((state) => state.layout);
  const panel = useStore((state) => state.panel);
  const presents = useStore((state) => state.presents);
  const id = useStore((state) => state.document?.id);
  return (
    <div className={`editor layout-${layout} panel-${panel}${presents ? " presents" : ""}`} style={style}>
      <SkipLinks />
      <Header />
      <div className="bars"><ServerBar /><OutsideBar /><Panels /></div>
      <div className="columns">
        <LeftSide />
        <main className="middle">
          <Splitter name="left" label="Width of the left panel" upright sizes={sizes} change={change} />
          {layout === "draw" && <Diagram />}
          {layout === "draw" && <Splitter name="lower" label="Height of the lower panels" upright={false} sizes={sizes} change={change} />}
          <div className="lower">
            <Picture key={id} />
            <Splitter name="picture" label="Width of the picture" upright sizes={sizes} change={change} />
            <LowerTabs />
          </div>
          <Progress />
          <Splitter name="right" label="Width of the properties" upright sizes={sizes} change={change} />
        </main>
        <Properties />
      </div>
    </div>
  );
}

const PLACES: readonly (readonly [Panel, string, string])[] = [
  ["left", "palette", ".left button:not([tabindex='-1']), .left input"],
  ["diagram", "diagram", ".react-flow__node"],
  ["right", "properties", ".properties input, .properties select, .properties button"],
  ["results", "results", ".panel [role='tab'][aria-selected='true']"],
];

/** Ways past groups of controls, seen when the keyboard comes to them. */
function SkipLinks(): ReactElement {
  const skip = (panel: Panel, selector: string): void => {
    useStore.setState({ panel, ...(panel === "diagram" ? { layout: "draw" } : {}) });
    setTimeout(() => { document.querySelector<HTMLElement>(selector)?.focus(); }); // when the panel is seen
  };
  return (
    <nav className="skips" aria-label="Skip to">
      {PLACES.map(([panel, title, selector]) => <button key={panel} type="button" className="button small" onClick={() => { skip(panel, selector); }}>Skip to the {title}</button>)}
    </nav>
  );
}

/** Another program changed the file. */
function OutsideBar(): ReactElement | null {
  const outside = useStore((state) => state.outside);
  if (!outside) return null;
  return (
    <div className="outside" role="alert">
      <Icon name="warning" size={16} /> Another program changed the file.
      <button type="button" className="button small" onClick={() => { void reloadFile(); }}>Reload</button>
      <button type="button" className="button small" onClick={() => { void save(true); }}>Overwrite</button>
      <button type="button" className="button small" onClick={() => { useStore.setState({ dialog: "saveAs" }); }}>Save as…</button>
    </div>
  );
}

const LEFT: readonly (readonly [LeftTab, string])[] = [["palette", "Palette"], ["trees", "Trees"]];

function LeftSide(): ReactElement {
  const tab = useStore((state) => state.leftTab);
  const roving = useRoving('[role="tab"]');
  return (
    <aside className="left" aria-label="Palette and trees">
      <h2 className="hidden">Palette and trees</h2>
      <div className="tabs"><div role="tablist" aria-label="Left side" {...roving}>
        {LEFT.map(([name, title]) => <button key={name} type="button" role="tab" aria-selected={tab === name} onClick={() => { useStore.setState({ leftTab: name }); }}>{title}</button>)}
      </div></div>
      {tab === "palette" ? <Palette /> : <Trees />}
    </aside>
  );
}

const LOWER: readonly (readonly [Tab, string])[] = [
  ["positions", "Positions"], ["curves", "Curves"], ["equations", "Equations"], ["analyses", "Analyses"], ["problems", "Problems"], ["notes", "Notes"],
];
const CONTENTS: Readonly<Record<Tab, () => ReactElement>> = {
  positions: Positions, curves: Curves, equations: Equations, analyses: Analyses, problems: Problems, notes: Notes,
};

function LowerTabs(): ReactElement {
  const tab = useStore((state) => state.tab);
  const large = useStore((state) => state.layout === "read");
  const roving = useRoving('[role="tab"]');
  const problems = useAllProblems();
  const counts: Partial<Record<Tab, number>> = { problems: problems.filter(isFault).length, notes: problems.filter((each) => !isFault(each)).length };
  const resize = (): void => { useStore.setState({ layout: large ? "draw" : "read" }); };
  const Content = CONTENTS[tab];
  return (
    <section className="panel" aria-label="Results">
      <h2 className="hidden">Results</h2>
      <div className="tabs" onDoubleClick={resize}>
        <div role="tablist" aria-label="Results" {...roving}>{LOWER.map(([name, title]) => (
          <button key={name} type="button" role="tab" aria-selected={tab === name} onClick={() => { useStore.setState({ tab: name }); }}>
            {title}{(counts[name] ?? 0) > 0 && <span className={`count${name === "notes" ? " quiet" : ""}`}>{counts[name]}</span>}
          </button>
        ))}</div>
        <button type="button" className="icon-button end" aria-pressed={large} aria-label="Maximize results" title="Maximize results (double-click the tabs)" onClick={resize}><Icon name="wide" size={15} /></button>
      </div>
      <div className="tab-body" role="tabpanel" aria-label={LOWER.find(([name]) => name === tab)?.[1]}><Content /></div>
    </section>
  );
}
