/** Jobs of the page: what computes does not wait for equations that are read, nor takes them away. */

import { beforeEach, describe, expect, it, vi } from "vitest";
import { api } from "../../src/builder/api";
import { cancelJobs, runJob, simulate } from "../../src/builder/commands/jobs";
import { edit, showDocument, useStore } from "../../src/builder/store";
import { withValue } from "../../src/builder/model/pointers";
import type { JobKind, JobState } from "../../src/builder/types";
import { sliderCrank } from "./models";

const ends = new Map<string, (state: JobState) => void>();
let started: string[] = [];
let cancelled: string[] = [];

const stateOf = (state: JobState["state"]): JobState => ({ seen: 0, stage: "", stages: [], percent: null, elapsed: 0, state, result: state === "done" ? {} : null, problems: [] });
const settle = async (): Promise<void> => { await new Promise((resolve) => { setTimeout(resolve); }); };
const lanes = (): Record<string, string | null> => Object.fromEntries(Object.entries(useStore.getState().runs).map(([lane, run]) => [lane, run.job]));

beforeEach(() => {
  ends.clear();
  [started, cancelled] = [[], []];
  vi.stubGlobal("matchMedia", () => ({ matches: false }));
  vi.spyOn(api, "job").mockImplementation(async (_, kind: JobKind) => { started.push(kind); return Promise.resolve(`${kind} ${started.length}`); });
  vi.spyOn(api, "jobState").mockImplementation(async (job) => new Promise((resolve) => { ends.set(job, resolve); }));
  vi.spyOn(api, "cancel").mockImplementation(async (job) => { cancelled.push(job); return Promise.resolve({}); });
  vi.spyOn(api, "equationTab").mockResolvedValue({ name: "Equations", blocks: [] });
  showDocument({ document: "d", path: null, name: "crank", data: sliderCrank, fingerprint: null, problems: [], comments: {}, wires: [] });
});

describe("a simulation", () => {
  it("runs beside the equations, which come all the same", async () => {
    void runJob("equations");
    await settle();
    simulate();
    await settle();
    expect(lanes()).toEqual({ equations: "equations 1", computation: "simulate 2" });
    ends.get("simulate 2")!(stateOf("done"));
    await settle();
    expect(lanes()).toEqual({ equations: "equations 1" });
    ends.get("equations 1")!(stateOf("done"));
    await settle();
    expect(useStore.getState().equations?.job).toBe("equations 1");
    expect([lanes(), cancelled]).toEqual([{}, []]);
  });

  it("begins once for one model, and anew after an edit", async () => {
    simulate();
    simulate();
    await settle();
    simulate();
    await settle();
    expect([started, cancelled]).toEqual([["simulate"], []]);
    edit((before) => withValue(before, "/body/0/mass", "2"));
    simulate();
    await settle();
    expect([started, cancelled, lanes()]).toEqual([["simulate", "simulate"], ["simulate 1"], { computation: "simulate 2" }]);
  });

  it("that fails leaves the way free and says why", async () => {
    simulate();
    await settle();
    const problem = { severity: "error", code: "x", what: "no", why: "", fix: "" };
    ends.get("simulate 1")!({ ...stateOf("failed"), problems: [problem] as unknown as JobState["problems"] });
    await settle();
    expect([lanes(), useStore.getState().notice]).toEqual([{}, [problem]]);
  });

  it("is cancelled alone", async () => {
    void runJob("equations");
    simulate();
    await settle();
    cancelJobs(["computation"]);
    await settle();
    expect(lanes()).toEqual({ equations: "equations 1" });
    expect(cancelled).toContain("simulate 2");
  });

  it("of a model that was closed ends", async () => {
    simulate();
    await settle();
    showDocument({ document: "e", path: null, name: "other", data: sliderCrank, fingerprint: null, problems: [], comments: {}, wires: [] });
    ends.get("simulate 1")!(stateOf("running"));
    await settle();
    expect([lanes(), cancelled]).toEqual([{}, ["simulate 1"]]);
  });
});
