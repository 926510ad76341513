// @vitest-environment jsdom
import { describe, expect, it } from "vitest";
import type { Event } from "../src/api/types";
import { includes } from "../src/app/session";
import { combined, matches } from "../src/events/history";
import { frameState } from "../src/scene/frame-state";
import { formatDuration, formatStamp, withSince } from "../src/ui/format";

describe("durations and times", () => {
  it("reads as people say it", () => {
    expect([-5, 40, 1234, 59_000, 200_000, 7_500_000, 4 * 86_400_000].map(formatDuration)).toEqual([
      "0 ms",
      "40 ms",
      "1.2 s",
      "59 s",
      "3 min 20 s",
      "2 h 5 min",
      "4 days",
    ]);
  });

  it("has the date only when it is not today", () => {
    const noon = new Date(2025, 4, 17, 12, 3, 10).getTime();
    expect(formatStamp(noon * 1e6, noon + 1000)).toBe("12:03:10");
    expect(formatStamp(noon * 1e6, noon + 86_400_000)).toBe("2025-05-17 12:03:10");
  });

  it("adds since when, unless the sentence says it", () => {
    expect(withSince({ text: "no frames since 12:03:10", since_ns: 1 })).toBe("no frames since 12:03:10");
    expect(withSince({ text: "no frames", since_ns: null })).toBe("no frames");
    expect(withSince({ text: "no frames", since_ns: Date.now() * 1e6 })).toMatch(
      /^no frames \(since \d\d:\d\d:\d\d\)$/,
    );
  });
});

describe("roles", () => {
  it("include the smaller ones; a robot is apart", () => {
    expect(includes("admin", "operator")).toBe(true);
    expect(includes("operator", "operator")).toBe(true);
    expect(includes("viewer", "operator")).toBe(false);
    expect(includes("robot", "viewer")).toBe(false);
    expect(includes("admin", "robot")).toBe(false);
  });
});

describe("the history", () => {
  const event = (stamp_ns: number, text = "x", level: Event["level"] = "info"): Event => ({
    stamp_ns,
    level,
    source: "cam2",
    kind: "camera_lost",
    text,
  });

  it("shows fetched and live events once, newest first", () => {
    const stamps = combined([event(1), event(2)], [event(2), event(3)]).map(({ stamp_ns }) => stamp_ns);
    expect(stamps).toEqual([3, 2, 1]);
  });

  it("filters by level and by every word, wherever it stands", () => {
    expect(matches(event(1, "no frame", "warning"), "warning", "CAM2 frame lost")).toBe(true);
    expect(matches(event(1, "no frame", "warning"), "error", "")).toBe(false);
    expect(matches(event(1, "no frame"), "info", "frame cam3")).toBe(false);
  });
});

describe("the frame of the 3D view", () => {
  const page = (body: string) => {
    const made = document.implementation.createHTMLDocument();
    made.body.innerHTML = body;
    Object.defineProperty(made, "readyState", { value: "complete" });
    Object.defineProperty(made, "URL", { value: "http://lab/viser/" });
    return made;
  };

  it("is missing when something else than viser answers", () => {
    expect(frameState(page('{"detail": "the scene is away"}'))).toBe("missing");
  });

  it("is alive while viser says that it is connected, dead while it says that it is not", () => {
    expect(frameState(page('<div id="root"><canvas></canvas><i class="tabler-icon-cloud-check"></i></div>'))).toBe(
      "alive",
    );
    expect(frameState(page('<div id="root"><canvas></canvas><i class="tabler-icon-player-pause"></i></div>'))).toBe(
      "dead",
    );
  });

  it("is loading until something is drawn", () => {
    expect(frameState(null)).toBe("loading");
    expect(frameState(page('<div id="root"></div>'))).toBe("loading");
    expect(frameState(page('<div id="root"><canvas></canvas></div>'))).toBe("alive");
  });
});
