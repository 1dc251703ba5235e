/** Long work of the server: started, followed, cancelled. */

import { api, problemsOf } from "../api";
import { endGesture, say, useStore, type Lane, type Panel, type Run, type SimulationOptions, type Tab } from "../store";
import type { JobKind, JobState, Json, JsonObject, Model } from "../types";

const LANES: readonly Lane[] = ["computation", "equations"];
let turns = 0;

export function laneOf(kind: JobKind): Lane {
  return kind === "equations" ? "equations" : "computation";
}

function runIn(lane: Lane): Run | undefined {
  return useStore.getState().runs[lane];
}

/** Whether a run is the one in its lane: neither cancelled nor replaced. */
function isCurrent({ kind, turn }: Run): boolean {
  return runIn(laneOf(kind))?.turn === turn;
}

/** Put a run into its lane; undefined: nothing runs there. */
function setRun(lane: Lane, run: Run | undefined): void {
  const others = Object.entries(useStore.getState().runs).filter(([name]) => name !== lane);
  useStore.setState({ runs: Object.fromEntries(run === undefined ? others : [...others, [lane, run]]) });
}

function isSame(one: Run, other: Run): boolean {
  return one.kind === other.kind && one.of === other.of && one.options === other.options;
}

/** Run a job to its end, and keep its result; it takes the place of what runs in its lane, unless that is the same. */
export async function runJob(kind: JobKind, options: Json = {}): Promise<void> {
  const { data, document } = useStore.getState();
  const lane = laneOf(kind);
  const before = runIn(lane);
  const run: Run = { kind, job: null, state: null, of: data, options: JSON.stringify(options), turn: turns += 1 };
  if (before !== undefined && isSame(before, run)) return;
  endGesture();
  setRun(lane, run);
  useStore.setState({ notice: [], spoken: `${labelOfJob(kind)} started` });
  try {
    await endJob(before);
    if (!isCurrent(run)) return;
    const job = await api.job(document?.id ?? "", kind, data, options);
    const state = await followJob({ ...run, job });
    if (state !== null) takeResult(kind, job, data, state);
  } catch (error) {
    if (!isCurrent(run)) return;
    setRun(lane, undefined);
    useStore.setState({ notice: problemsOf(error) });
  }
}

/** Follow a job until it leaves its lane; null where it was cancelled, or replaced by another one or by another model. */
async function followJob(run: Run & { readonly job: string }): Promise<JobState | null> {
  const lane = laneOf(run.kind);
  for (let state: JobState | null = null; isCurrent(run); state = await api.jobState(run.job, state?.seen ?? -1)) {
    const ended = state !== null && state.state !== "running";
    setRun(lane, ended ? undefined : { ...run, state });
    if (ended) return state;
  }
  await endJob(run);
  return null;
}

/** Derive the equations, in view of where they come. */
export function deriveEquations(): void {
  showResults({ tab: "equations" });
  void runJob("equations");
}

/** Show a tab of the results; where one panel fills the window, that panel. */
function showResults(tab: { readonly tab: Tab }, panel: Panel = "results"): void {
  useStore.setState(window.matchMedia("(max-width: 700px)").matches ? { ...tab, panel } : tab);
}

function takeResult(kind: JobKind, job: string, of: Model, state: JobState): void {
  const { result } = state;
  if (state.state !== "done" || result === null) {
    useStore.setState({ notice: state.problems, spoken: `${labelOfJob(kind)} ${state.state}` });
    return;
  }
  useStore.setState({ notice: state.problems });
  if (kind === "equations") {
    useStore.setState({ equations: { of, job, result } });
    void writeTab("Equations"); // once more, with the sources of its terms, while all else goes on
  } else if (result["scene"] !== undefined && result["motion"] !== undefined) {
    const title = useStore.getState().document?.name ?? "";
    useStore.setState({ simulated: { job, of, scene: result["scene"], motion: result["motion"], result, title }, showsMotion: true, analysisPicture: null });
    showResults({ tab: "curves" }, "picture");
  } else {
    useStore.setState({ analysisPicture: null, analysis: { kind, of, result } });
    showResults({ tab: "analyses" });
  }
  say(`${labelOfJob(kind)} finished`);
}

/** Put a tab of the last equations into the store; the process that derived them writes it. */
export async function writeTab(name: string): Promise<void> {
  const asked = useStore.getState().equations;
  if (asked === null) return;
  const tab = await api.equationTab(asked.job, name).catch((error: unknown) => ({ name, blocks: [], note: problemsOf(error).map(({ what }) => what).join(" ") }));
  const { equations } = useStore.getState();
  if (equations?.job !== asked.job) return;
  const { result } = equations;
  const tabs = (Array.isArray(result?.["tabs"]) ? result["tabs"] as JsonObject[] : []).filter((each) => each["name"] !== name);
  useStore.setState({ equations: { ...equations, result: { ...result, tabs: [...tabs, tab] } } });
}

/** End what runs, in one lane or in all. */
export function cancelJobs(lanes: readonly Lane[] = LANES): void {
  for (const lane of lanes) {
    const run = runIn(lane);
    setRun(lane, undefined);
    void endJob(run);
  }
  say("Cancelled");
}

async function endJob(run: Run | undefined): Promise<void> {
  if (run?.job != null) await api.cancel(run.job).catch(() => undefined);
}

const LABELS: Readonly<Record<JobKind, string>> = {
  equations: "Equations", simulate: "Simulation", equilibrium: "Equilibrium", modes: "Modes", singular: "Dead positions", ratios: "Velocity ratios", torque: "Torque for constant speed",
  inverse: "Inverse dynamics", sweep: "Sweep",
};

export function labelOfJob(kind: JobKind): string {
  return LABELS[kind];
}

/** Simulate, by default as the last time. */
export function simulate(options: SimulationOptions = useStore.getState().simulation): void {
  useStore.setState({ simulation: options });
  const inputs = Object.fromEntries(Object.entries(options.inputs).filter(([, text]) => text.trim() !== ""));
  const samples = options.step === null ? {} : { samples: Math.max(2, Math.round(options.t_end / options.step) + 1) };
  void runJob("simulate", { t_end: options.t_end, inputs, solver: options.solver, rtol: options.rtol, ...samples });
}
