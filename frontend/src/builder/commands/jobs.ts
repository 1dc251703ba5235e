/** Long work of the server: started, followed, cancelled. */

import { api, problemsOf } from "../api";
import { endGesture, say, useStore, type Panel, type SimulationOptions, type Tab } from "../store";
import type { JobKind, JobState, Json, JsonObject, Model } from "../types";

function finished({ state }: JobState): boolean {
  return state !== "running";
}

/** Run a job to its end, and keep its result. */
export async function runJob(kind: JobKind, options: Json = {}): Promise<void> {
  const { data, run, document } = useStore.getState();
  if (run?.state !== undefined && run.state !== null && !finished(run.state)) await cancelJob();
  endGesture();
  useStore.setState({ run: { kind, job: null, state: null, of: data }, notice: [], spoken: `${labelOfJob(kind)} started` });
  try {
    const job = await api.job(document?.id ?? "", kind, data, options);
    useStore.setState({ run: { kind, job, state: null, of: data } });
    const state = await followJob(kind, job, data);
    if (state !== null) takeResult(kind, job, data, state);
  } catch (error) {
    useStore.setState({ run: null, notice: problemsOf(error) });
  }
}

/** Follow a job; null where another one took its place. */
async function followJob(kind: JobKind, job: string, of: Model): Promise<JobState | null> {
  let seen = -1;
  for (;;) {
    const state = await api.jobState(job, seen);
    ({ seen } = state);
    if (useStore.getState().run?.job !== job) return null;
    useStore.setState({ run: { kind, job, state, of } });
    if (finished(state)) return state;
  }
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
  useStore.setState({ run: null, notice: state.problems });
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

export async function cancelJob(): Promise<void> {
  const { run } = useStore.getState();
  if (run === null) return;
  useStore.setState({ run: null, spoken: "Cancelled" });
  if (run.job !== null) await api.cancel(run.job).catch(() => undefined);
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
