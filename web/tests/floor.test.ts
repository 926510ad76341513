import { describe, expect, it } from "vitest";
import type { LabView, RobotView } from "../src/api/types";
import { areaAt, freeId } from "../src/floor/edits";
import { parseBounds } from "../src/floor/FloorPicture";
import { gridPitch } from "../src/floor/paint/ground";
import { visibleFootprint } from "../src/floor/paint/robots";
import { paletteOf } from "../src/floor/palette";
import { RobotMarks } from "../src/floor/RobotMarks";
import { swapped } from "../src/routes/LegList";

describe("placing waypoints", () => {
  const lab = {
    areas: [
      { id: "hall", outline: [[0, 0], [4, 0], [4, 4], [0, 4]] },
      { id: "yard", outline: [[4, 0], [8, 0], [8, 4], [4, 4]] },
    ],
  } as unknown as LabView; // prettier-ignore

  it("takes the first free number", () => {
    expect(freeId("wp", {})).toBe("wp-1");
    expect(freeId("wp", { "wp-1": 0, "wp-3": 0 })).toBe("wp-2");
  });

  it("finds the area, and names the first one outside all so that the server can refuse", () => {
    expect(areaAt(lab, [6, 1])).toBe("yard");
    expect(areaAt(lab, [99, 1])).toBe("hall");
  });
});

describe("the bounds of the floor picture", () => {
  it("are four numbers that span an area", () => {
    expect(parseBounds("-0.35,-0.3,8.35,4.6")).toEqual([-0.35, -0.3, 8.35, 4.6]);
    for (const bad of [null, "", "1,2,3", "1,2,3,x", "0,0,0,1", "1,2,3,4,5"]) expect(parseBounds(bad)).toBeNull();
  });
});

describe("drawing", () => {
  it("has a line every metre unless they would be too dense", () => {
    expect(gridPitch(100)).toBe(1);
    expect(gridPitch(36)).toBe(1);
    expect(gridPitch(20)).toBe(2);
    expect(gridPitch(1)).toBe(50);
  });

  it("keeps robots big enough to hit", () => {
    const corner = [[0.1, 0]] as const;
    expect(visibleFootprint(corner, 1000)).toEqual([[0.1, 0]]);
    expect((visibleFootprint(corner, 10)[0]?.[0] ?? 0) * 10).toBeCloseTo(14);
  });

  it("swaps neighbouring legs and nothing beyond the ends", () => {
    expect(swapped(["a", "b", "c"], 2, 1)).toEqual(["a", "c", "b"]);
    expect(swapped(["a", "b"], 0, -1)).toEqual(["a", "b"]);
  });
});

describe("robots on the map", () => {
  const square = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]; // prettier-ignore
  const robotAt = (x: number, parts: object = {}) =>
    ({
      r: {
        id: "r",
        footprint: square,
        state: "idle",
        reason: null,
        guidance: null,
        pose: { x, y: 0, yaw: 0, stamp_ns: 0 },
        ...parts,
      },
    }) as unknown as Record<string, RobotView>;

  it("are drawn again only when something can be seen to change", () => {
    const marks = new RobotMarks();
    expect(marks.update(robotAt(1), 0, 0)).toBe(true);
    expect(marks.update(robotAt(1.0005), 0, 50)).toBe(false);
    expect(marks.update(robotAt(1.05), 0, 100)).toBe(true);
    expect(marks.isMoving(100)).toBe(true);
    expect(marks.update(robotAt(1.05, { state: "waiting" }), 0, 1000)).toBe(true);
    expect(marks.update({}, 0, 1100)).toBe(true);
    expect(marks.update({}, 0, 1150)).toBe(false);
  });

  it("fade with their age in the label once no camera sees them", () => {
    const marks = new RobotMarks();
    marks.update(robotAt(1), 100, 0);
    expect(marks.marks(paletteOf("dark"), null, 100, 0)[0]?.mark).toMatchObject({ isStale: false, label: "r" });
    expect(marks.update(robotAt(1), 3400, 3300)).toBe(true);
    const [drawn] = marks.marks(paletteOf("dark"), "r", 3400, 3300);
    expect(drawn?.mark).toMatchObject({ isStale: true, isSelected: true, label: "r · seen 3.0 s ago" });
  });

  it("are found under the pointer", () => {
    const marks = new RobotMarks();
    marks.update(robotAt(1), 0, 0);
    expect(marks.at([1.1, 0.1], 100, 0)).toBe("r");
    expect(marks.at([1.5, 0], 100, 0)).toBeNull();
  });

  it("have no place before a camera has seen them", () => {
    const marks = new RobotMarks();
    marks.update(robotAt(1, { pose: null }), 0, 0);
    expect(marks.poseOf("r", 0)).toBeNull();
  });
});
