/** Long work of the server: started, followed, cancelled. */

import { api, problemsOf } from "../api";
import { endGesture, say, useStore, type SimulationOptions } from "../store";
import type { JobKind, JobState, Json, JsonObject, Model } from "../types";

function finished({ state }: JobState): boolean {
  return state !== "running";
}

/** Run a job to its end, and keep its result. */
export async function runJob(kind: JobKind, options: Json = {}): Promise<void> {
  const { data, run, document } = useStore.getState();
  if (run?.state !== undefined && run.state !== null && !finished(run.state)) await cancelJob();
  endGesture();
  useStore.setState({ run: { kind, job: null, state: null, of: data, parts: [] }, notice: [], spoken: `${labelOfJob(kind)} started` });
  try {
    const job = await api.job(document?.id ?? "", kind, data, options);
    useStore.setState({ run: { kind, job, state: null, of: data, parts: [] } });
    const state = await followJob(kind, job, data);
    if (state !== null) takeResult(kind, job, data, state);
  } catch (error) {
    useStore.setState({ run: null, notice: problemsOf(error) });
  }
}

/** Follow a job; null where another one took its place. */
async function followJob(kind: JobKind, job: string, of: Model): Promise<JobState | null> {
  let seen = -1;
  let parts: readonly JsonObject[] = [];
  for (;;) {
    const state = await api.jobState(job, seen);
    ({ seen } = state);
    if (useStore.getState().run?.job !== job) return null;
    if (parts.length === 0 && state.parts.length > 0) useStore.setState({ tab: "equations" }); // they alone come in parts
    parts = [...parts, ...state.parts];
    useStore.setState({ run: { kind, job, state, of, parts } });
    if (finished(state)) return state;
  }
}

function takeResult(kind: JobKind, job: string, of: Model, state: JobState): void {
  const { result } = state;
  if (state.state !== "done" || result === null) {
    useStore.setState({ notice: state.problems, spoken: `${labelOfJob(kind)} ${state.state}` });
    return;
  }
  useStore.setState({ run: null, notice: state.problems });
  if (kind === "equations") useStore.setState({ equations: { of, result }, tab: "equations" });
  else if (result["scene"] !== undefined && result["motion"] !== undefined) {
    const title = useStore.getState().document?.name ?? "";
    useStore.setState({ simulated: { job, of, scene: result["scene"], motion: result["motion"], result, title }, showsMotion: true, analysisPicture: null, tab: "curves" });
  } else useStore.setState({ analysisPicture: null, analysis: { kind, of, result }, tab: "analyses" });
  say(`${labelOfJob(kind)} finished`);
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
