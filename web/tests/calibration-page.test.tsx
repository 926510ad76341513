// @vitest-environment jsdom
import { MantineProvider } from "@mantine/core";
import { act, cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Calibration, CalibrationProposal, Role } from "../src/api/types";
import { useSession } from "../src/app/session";
import { CompareStep } from "../src/calibration/CompareStep";
import { InForce } from "../src/calibration/InForce";

const fetch = vi.fn<typeof globalThis.fetch>(() => Promise.resolve(new Response("{}")));
const calibration: Calibration = {
  id: 1700000000007,
  stamp_ns: 1,
  by: "olga",
  floor_basis: "f",
  cameras: {
    cam0: {
      rotvec: [3.1, 0, 0],
      translation: [1, 2, 3],
      covariance: [],
      reprojection_px: 0.21,
      floor_tags: [0, 1],
      left_out: [],
      basis: "b",
    },
  },
  floor_tags: { 0: { x: 0, y: 0, yaw: 0, shift_m: 0.0012 } },
};
const proposal: CalibrationProposal = {
  calibration,
  cameras: {
    cam0: {
      is_new: true,
      frames: 10,
      corner_noise_px: 0.03,
      floor_tags: [0, 1],
      left_out: [3],
      reprojection_before_px: 2.5,
      reprojection_after_px: 0.21,
      floor_shift_mean_m: 0.0184,
      floor_shift_max_m: 0.0213,
      camera_moved_m: 0.02,
      camera_turned_rad: 0.001,
      floor_std_before_m: null,
      floor_std_after_m: 0.0007,
    },
  },
  floor_tags: { 0: { shift_m: 0.0004, cameras: ["cam0"] } },
  not_answered: [],
};

function logIn(role: Role) {
  useSession.setState({ state: "in", user: "olga", role }, true);
}

async function click(part: string) {
  await act(async () => {
    fireEvent.click(screen.getByTestId(part));
    await Promise.resolve();
  });
}

const show = (element: React.ReactNode) => render(<MantineProvider>{element}</MantineProvider>);
const sent = () => fetch.mock.calls.map(([address, options]) => [options?.method, address, options?.body]);
const done = vi.fn(() => Promise.resolve());

beforeEach(() => {
  vi.stubGlobal("fetch", fetch);
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: vi.fn(), removeEventListener: vi.fn() }));
  vi.stubGlobal(
    "ResizeObserver",
    class {
      observe = vi.fn();
      unobserve = vi.fn();
      disconnect = vi.fn();
    },
  );
  logIn("operator");
});
afterEach(() => {
  cleanup();
  fetch.mockClear();
  done.mockClear();
  vi.unstubAllGlobals();
});

describe("the comparison", () => {
  it("shows what a camera would change, and what was not believed", () => {
    show(<CompareStep proposal={proposal} note="" onDecided={done} />);
    const row = screen.getByTestId("calibration-camera-cam0").textContent;
    for (const text of ["2.50 px", "0.21 px", "18 mm, 21 mm", "20 mm, 0.06°", "–, 0.7 mm", "not believed: 3", "better"])
      expect(row).toContain(text);
    expect(screen.getByTestId("calibration-floor-tags").textContent).toContain("0.4 mm1.2 mm");
  });

  it("decides about the proposal that was looked at", async () => {
    show(<CompareStep proposal={proposal} note="" onDecided={done} />);
    await click("calibration-accept");
    await click("calibration-discard");
    expect(sent()).toEqual([
      ["POST", "/api/calibration/accept", '{"id":1700000000007}'],
      ["POST", "/api/calibration/discard", '{"id":1700000000007}'],
    ]);
  });

  it("says which cameras did not take part", () => {
    show(<CompareStep proposal={proposal} note="cam2 did not answer (not connected)" onDecided={done} />);
    expect(screen.getByText(/cam2 did not answer \(not connected\)\./)).toBeTruthy();
  });

  it("is not decided by viewers", () => {
    logIn("viewer");
    show(<CompareStep proposal={proposal} note="" onDecided={done} />);
    expect(screen.getByTestId<HTMLButtonElement>("calibration-accept").disabled).toBe(true);
    expect(screen.getByTestId<HTMLButtonElement>("calibration-discard").disabled).toBe(true);
  });
});

describe("what is in force", () => {
  it("says how it came about, and has nothing to undo at first", () => {
    show(<InForce current={{ ...calibration, by: "calibrator" }} previous={null} onChanged={done} />);
    expect(screen.getByTestId("calibration-in-force").textContent).toMatch(
      /cam0 with 1 floor tags?, at most 0\.21 px off; since .*, made by itself/,
    );
    expect(screen.queryByTestId("calibration-restore")).toBeNull();
  });

  it("goes back to what was before", async () => {
    show(<InForce current={calibration} previous={calibration} onChanged={done} />);
    await click("calibration-restore");
    expect(sent()).toEqual([["POST", "/api/calibration/restore", undefined]]);
  });

  it("says why there is none", () => {
    show(<InForce current={null} previous={null} onChanged={done} />);
    expect(screen.getByTestId("calibration-in-force").textContent).toContain("made by itself as soon as");
  });
});
