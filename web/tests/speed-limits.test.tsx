// @vitest-environment jsdom
import { MantineProvider } from "@mantine/core";
import { act, cleanup, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { LabView, LiveMessage, SpeedZone } from "../src/api/types";
import { toggleLayer, useFloor } from "../src/floor/floor-state";
import { paintFloor } from "../src/floor/paint/scene";
import { paletteOf } from "../src/floor/palette";
import type { Pen } from "../src/floor/Pen";
import { SpeedLimits } from "../src/floor/SpeedLimits";
import { fromSnapshot } from "../src/live/merge";
import { forget, takeMessage } from "../src/live/store";

const OUTLINE: SpeedZone["outline"] = [[3, 1], [4, 1], [4, 2], [3, 2]]; // prettier-ignore
const zone = (id: string, speed_mps: number): SpeedZone => ({ id, outline: OUTLINE, speed_mps });
const snapshot = (zones: readonly SpeedZone[]) =>
  ({
    type: "snapshot",
    stamp_ns: 1,
    robots: {},
    cameras: {},
    waypoints: {},
    routes: {},
    objects: {},
    zones: {},
    speed_zones: Object.fromEntries(zones.map((each) => [each.id, each])),
    estop: { engaged: false },
    obstacles: null,
    health: { state: "ok" },
    events: [],
  }) as unknown as Extract<LiveMessage, { type: "snapshot" }>;

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: vi.fn(), removeEventListener: vi.fn() }));
});
afterEach(() => {
  cleanup();
  act(() => forget());
  if (!useFloor.getState().layers.speeds) toggleLayer("speeds");
  vi.unstubAllGlobals();
});

describe("the legend of speed limits", () => {
  const show = (zones: readonly SpeedZone[]) => {
    takeMessage(snapshot(zones));
    return render(<SpeedLimits />, { wrapper: MantineProvider });
  };

  it("names every zone with its limit, and follows what is drawn and deleted", () => {
    show([zone("ramp", 0.35), zone("doorway", 0.2)]);
    expect(screen.getByTestId("speed-limits").textContent).toBe(
      "Speed limitsdoorway: at most 0.2 m/sramp: at most 0.35 m/s",
    );
    act(() => takeMessage({ type: "changes", stamp_ns: 2, speed_zones: { doorway: null, ramp: zone("ramp", 1) } }));
    expect(screen.getByTestId("speed-limits").textContent).toBe("Speed limitsramp: at most 1 m/s");
  });

  it("counts those that it has no room for", () => {
    show(Array.from({ length: 9 }, (_, index) => zone(`zone-${index}`, 0.2)));
    expect(screen.getByText("and 3 more")).toBeTruthy();
  });

  it("is gone without zones, and with their layer", () => {
    show([]);
    expect(screen.queryByTestId("speed-limits")).toBeNull();
    act(() => takeMessage(snapshot([zone("ramp", 0.2)])));
    expect(screen.queryByTestId("speed-limits")).not.toBeNull();
    act(() => toggleLayer("speeds"));
    expect(screen.queryByTestId("speed-limits")).toBeNull();
  });
});

describe("zones on the map", () => {
  const painted = (speeds: boolean) => {
    const said: string[] = [];
    const filled: unknown[] = [];
    const pen = {
      pixelsPerMetre: 100,
      extent: [0, 0, 8, 4],
      outline: vi.fn(),
      line: vi.fn(),
      fill: (points: unknown) => filled.push(points),
      chip: (_place: unknown, _belowPx: number, text: string) => said.push(text),
    } as unknown as Pen;
    paintFloor(pen, {
      palette: paletteOf("light"),
      lab: { areas: [] } as unknown as LabView,
      picture: null,
      state: fromSnapshot(snapshot([zone("ramp", 0.35)])),
      obstacles: [],
      layers: {
        picture: false,
        grid: false,
        zones: false,
        speeds,
        cameras: false,
        routes: false,
        obstacles: false,
        boxes: false,
        waypoints: false,
      },
    });
    return { said, filled };
  };

  it("are filled and carry their limit", () => {
    expect(painted(true).said).toContain("≤ 0.35 m/s");
    expect(painted(true).filled).toEqual([OUTLINE]);
  });

  it("are not drawn without their layer", () => {
    expect(painted(false).said).not.toContain("≤ 0.35 m/s");
    expect(painted(false).filled).toEqual([]);
  });
});
