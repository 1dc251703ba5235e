import { describe, expect, it } from "vitest";
import { componentLabels, fieldsOf, type Acting } from "../../src/builder/model/fields";
import { definitionNode } from "../../src/builder/model/schema";
import { searched } from "../../src/builder/panels/palette";
import { elements, schema } from "./models";

function kinds(definition: string): Record<string, string> {
  return Object.fromEntries(fieldsOf(schema, definitionNode(schema, definition)).map(({ key, control }) => [key, control.kind]));
}

describe("forms from the schema", () => {
  it("have a control of their own for every field of every element", () => {
    for (const { definition } of elements) {
      const own = kinds(definition);
      expect(Object.keys(own).length, definition).toBeGreaterThan(1);
      expect(Object.entries(own).filter(([, kind]) => kind === "json"), definition).toEqual([]);
    }
  });

  it("show a revolute joint as its parts are", () => {
    expect(kinds("RevoluteEntry")).toMatchObject({
      name: "name", between: "reference", tree: "tree", axis: "axis", coordinate: "text", torque: "group", motion: "formula", as_constraint: "switch",
    }); // prettier-ignore
    expect(kinds("RevoluteEntry")["type"]).toBeUndefined();
    expect(kinds("BodyEntry")).toMatchObject({ inertia: "vector", frames: "map" });
    expect(kinds("SpringEntry")["law"]).toBe("law");
    expect(kinds("BushingEntry")["stiffness"]).toBe("vector");
  });

  it("take units and labels from the descriptions", () => {
    const body = fieldsOf(schema, definitionNode(schema, "BodyEntry"));
    expect(body.find((each) => each.key === "mass")).toMatchObject({ unit: "kg", tip: "Mass; zero is allowed as long as the mechanism as a whole has mass in every direction of motion." });
    expect(body.find((each) => each.key === "inertia")?.control).toMatchObject({ labels: ["xx", "yy", "zz"] });
    const drive = definitionNode(schema, "DriveEntry");
    const units = (acting: Acting): string[] => ["applied", "stiffness", "damping", "free"].map((key) => fieldsOf(schema, drive, acting).find((each) => each.key === key)!.unit);
    expect(units("torque")).toEqual(["N·m", "N·m/rad", "N·m·s/rad", "rad"]);
    expect(units("force")).toEqual(["N", "N/m", "N·s/m", "m"]);
    expect(fieldsOf(schema, drive).find((each) => each.key === "applied")).toMatchObject({ unit: "", tip: "Applied force or torque on the end body. [N, N·m]" });
    expect(componentLabels("Components [N].", 3)).toEqual(["x", "y", "z"]);
  });

  it("finds elements by words, those first whose title begins so", () => {
    expect(searched(elements, "rev")[0]?.type).toBe("revolute");
    expect(searched(elements, "spring")[0]?.section).toBe("spring");
    expect(searched(elements, "nothing like it")).toEqual([]);
  });
});
