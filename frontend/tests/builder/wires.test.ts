import { beforeEach, describe, expect, it } from "vitest";
import { addElement, copyEntries, removeEntries } from "../../src/builder/model/edit";
import { diagramOf } from "../../src/builder/model/graph";
import { forgetArrangement, sizeOf, spotsOf, withLayout } from "../../src/builder/model/layout";
import { renameCoordinate, renameEntry, renameFrame } from "../../src/builder/model/rename";
import { formOf, hiddenFields, withForm } from "../../src/builder/model/signal_forms";
import { arrowHead, labelBox, wireCurve } from "../../src/builder/model/wire_paths";
import { keepWires, wiresOf } from "../../src/builder/model/wires";
import { entryAt } from "../../src/builder/model/entries";
import { valueAt } from "../../src/builder/model/pointers";
import type { Model, ServedWire } from "../../src/builder/types";
import { elementNamed, schema } from "./models";

const servo: Model = {
  inputs: ["goal"],
  body: [{ name: "Rod", mass: "1", frames: { tip: { at: ["1", "0", "0"] } } }],
  joint: [{ name: "pin", type: "revolute", between: ["ground", "Rod"], torque: { applied: "drive - pin_dot" } }],
  force: [{ name: "push", on: "FL_Shank.foot", vector: ["error", "0", "0"] }],
  signal: [{ name: "error", value: "goal - pin" }, { name: "high", output: "frame r Rod.tip ground ground y" }],
  block: [{ name: "drive", type: "dc_motor", voltage: "error", speed: "pin_dot", resistance: "1", inductance: "1", constant: "drive_current" }],
  include: [{ file: "leg.toml", prefix: "FL", at: "Rod.tip" }],
};
const wire = (source: string, target: string, names: string[], roots = names): ServedWire => ({ source: `/${source}`, target: `/${target}`, names, roots });
const served = [
  wire("block/0", "joint/0", ["drive"]), wire("inputs/0", "signal/0", ["goal"]), wire("joint/0", "signal/0", ["pin"]),
  wire("body/0", "signal/1", ["Rod.tip"], ["Rod"]), wire("signal/0", "force/0", ["error"]), wire("signal/0", "block/0", ["error"]),
  wire("joint/0", "block/0", ["pin_dot"], ["pin"]), wire("block/0", "signal/0", ["drive_current"]),
]; // prettier-ignore

beforeEach(() => {
  keepWires(servo, served);
  forgetArrangement();
});

describe("the diagram of signals", () => {
  it("has a node for each signal, block, input and part, and a port where something is joined to a part", () => {
    const graph = diagramOf(servo);
    expect(graph.nodes.map((each) => [each.name, each.kind])).toEqual([
      ["Ground", "ground"], ["Rod", "body"], ["error", "signal"], ["high", "signal"], ["drive", "signal"], ["FL", "part"], ["goal", "signal"],
    ]); // prettier-ignore
    expect(graph.nodes.find((each) => each.name === "FL")?.frames).toEqual(["Shank.foot"]);
    expect(graph.edges.map((each) => each.name)).toEqual(["pin", "push"]);
    expect(graph.attachments).toEqual([{ part: "include/0", node: "body/0", frame: "tip" }]);
    expect(graph.wires).toHaveLength(served.length);
    expect(graph.nodes.find((each) => each.name === "drive")?.detail).toBe("error, pin_dot");
  });

  it("shows a table with the name of an input in place of the input", () => {
    const graph = diagramOf({ ...servo, table: [{ name: "goal", file: "goal.csv" }] });
    expect(graph.nodes.filter((each) => each.name === "goal").map((each) => each.section)).toEqual(["table"]);
  });

  it("is arranged without overlap, signals below all else, what reads right of what is read", () => {
    const graph = diagramOf(servo);
    const spots = spotsOf(servo, graph);
    const boxes = graph.nodes.map((node) => ({ node, at: spots.get(node.id)!, ...sizeOf(node) }));
    for (const one of boxes) {
      for (const other of boxes) {
        if (one === other) continue;
        const apart = one.at[0] + one.width <= other.at[0] || other.at[0] + other.width <= one.at[0] || one.at[1] + one.height <= other.at[1] || other.at[1] + other.height <= one.at[1];
        expect(apart, `${one.node.name} ${other.node.name}`).toBe(true);
      }
    }
    expect(spots.get("inputs/0")![0]).toBeLessThan(spots.get("signal/0")![0]);
    expect(spots.get("signal/0")![1]).toBeGreaterThan(spots.get("body/0")![1]);
  });

  it("keeps its places while formulas are typed, and inputs and parts under names of their own", () => {
    const before = spotsOf(servo, diagramOf(servo));
    keepWires(servo, []);
    expect(spotsOf(servo, diagramOf(servo))).toEqual(before);
    expect(Object.keys(valueAt(withLayout(servo), "/layout/nodes") as object)).toEqual(["ground", "Rod", "error", "high", "drive", "include.FL", "inputs.goal"]);
  });
});

describe("wires of another state of the model", () => {
  it("follow the entries by name, renamed ones by place", () => {
    const moved: Model = { ...servo, signal: [{ name: "new", value: "0" }, ...(servo["signal"] as Model[])] };
    expect(wiresOf(moved).find((each) => each.names[0] === "goal")?.target).toBe("signal/1");
    const renamed: Model = { ...servo, signal: [{ name: "fault", value: "goal - pin" }, (servo["signal"] as Model[])[1]!] };
    expect(wiresOf(renamed).find((each) => each.names[0] === "goal")?.target).toBe("signal/0");
    expect(wiresOf({ ...servo, signal: [] }).filter((each) => `${each.source}${each.target}`.includes("signal"))).toEqual([]);
  });
});

describe("names of signals", () => {
  it("are changed in all formulas, with what is called after them", () => {
    const error = renameEntry(schema, servo, "signal/0", "fault");
    expect(valueAt(error, "/block/0/voltage")).toBe("fault");
    expect(valueAt(error, "/force/0/vector")).toEqual(["fault", "0", "0"]);
    const drive = renameEntry(schema, servo, "block/0", "motor");
    expect(valueAt(drive, "/joint/0/torque/applied")).toBe("motor - pin_dot");
    expect(valueAt(drive, "/block/0/constant")).toBe("motor_current");
    const goal = renameEntry(schema, withLayout(servo), "inputs/0", "aim");
    expect([goal["inputs"], valueAt(goal, "/signal/0/value")]).toEqual([["aim"], "aim - pin"]);
    expect(Object.keys(valueAt(goal, "/layout/nodes") as object)).toContain("inputs.aim");
  });

  it("of joints, bodies and frames are changed in what reads them", () => {
    expect(valueAt(renameEntry(schema, servo, "joint/0", "hinge"), "/signal/0/value")).toBe("goal - hinge");
    expect(valueAt(renameEntry(schema, servo, "body/0", "Arm"), "/signal/1/output")).toBe("frame r Arm.tip ground ground y");
    expect(valueAt(renameFrame(servo, "body/0", "tip", "end"), "/signal/1/output")).toBe("frame r Rod.end ground ground y");
    const named: Model = { ...servo, joint: [{ ...(servo["joint"] as Model[])[0], coordinate: "pin" }] };
    expect(valueAt(renameCoordinate(schema, named, "pin", "phi"), "/block/0/speed")).toBe("phi_dot");
  });

  it("are free of other symbols for new ones, and new ones begin as something", () => {
    const { data, ids } = addElement(schema, { ...servo, parameters: { signal1: "1" } }, elementNamed("signal"), null, null);
    expect(entryAt(data, ids[0]!)?.value).toEqual({ name: "signal2", value: "0" });
    const pid = addElement(schema, servo, elementNamed("pid"), null, null);
    expect(entryAt(pid.data, pid.ids[0]!)).toMatchObject({ name: "pid1", type: "pid", value: { input: "0", gains: {} } });
  });
});

describe("parts and inputs", () => {
  it("are removed, never copied", () => {
    const removed = removeEntries(servo, ["inputs/0", "include/0"]);
    expect([removed["inputs"], removed["include"]]).toEqual([[], []]);
    expect(Object.keys(valueAt(removed, "/layout/nodes") as object).filter((each) => each.includes("."))).toEqual([]);
    expect(copyEntries(servo, ["inputs/0", "include/0", "signal/0"]).entries.map((each) => each.section)).toEqual(["signal"]);
  });
});

describe("forms of a signal", () => {
  it("are one of three, the formula going along", () => {
    const signal = entryAt(servo, "signal/0")!;
    expect([formOf(signal.value), hiddenFields(signal.value)]).toEqual(["value", ["output", "rate", "initial"]]);
    const state = withForm(servo, signal, "rate");
    expect(valueAt(state, "/signal/0")).toEqual({ name: "error", rate: "goal - pin" });
    expect(hiddenFields(entryAt(state, "signal/0")!.value)).toEqual(["value", "output"]);
    expect(valueAt(withForm(state, entryAt(state, "signal/0")!, "output"), "/signal/0")).toEqual({ name: "error", output: "energy" });
    expect(withForm(servo, signal, "value")).toBe(servo);
  });
});

describe("lines of wires", () => {
  const box = (x: number, y: number, sided: boolean): Parameters<typeof wireCurve>[0] => ({ middle: [x, y], width: 100, height: 60, sided });

  it("lead between signals from side to side, else from above or below", () => {
    const [start, , , end] = wireCurve(box(0, 0, true), box(300, 0, true));
    expect([start, end]).toEqual([[50, 0], [250, 0]]);
    const [out, , , into] = wireCurve(box(0, 0, false), box(0, 300, true));
    expect([out[1], into[1]]).toEqual([30, 270]);
    expect(arrowHead(wireCurve(box(0, 0, true), box(300, 0, true)))).toMatch(/^250\.0,0\.0 /);
  });

  it("have labels where they cover least", () => {
    const curve = wireCurve(box(0, 0, true), box(400, 0, true));
    const free = labelBox(curve, 40, []);
    expect(labelBox(curve, 40, [free]).x).not.toBe(free.x);
  });
});
