import { describe, expect, it } from "vitest";
import { componentLabels, fieldsOf, meaningOf, type Acting } from "../../src/builder/model/fields";
import { definitionNode } from "../../src/builder/model/schema";
import { grouped } from "../../src/builder/panels/field_frame";
import { searched } from "../../src/builder/panels/palette";
import type { Problem } from "../../src/builder/types";
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

  it("say once what is wrong in many places", () => {
    const at = (pointer: string, what = "No table."): Problem => ({ severity: "error", code: "file.misfit", what, why: "", fix: "", pointer, element: "", line: null, repair: null });
    const groups = grouped([at("/a/0"), at("/a/1"), at("/b", "Another."), at("/a/2")]);
    expect(groups.map(([first, count]) => [first.pointer, count])).toEqual([["/a/0", 3], ["/b", 1]]);
  });

  it("say what a parameter is, its unit once", () => {
    expect(meaningOf("kg m^2", "kg m^2, about the centres of mass")).toBe("kg·m² · about the centres of mass");
    expect(meaningOf("m", "between the posts")).toBe("m · between the posts");
    expect(meaningOf("m/s^2", "m/s^2")).toBe("m/s²");
    expect(meaningOf("", "a share")).toBe("a share");
    expect(meaningOf("", "")).toBe("");
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
