import { describe, expect, it } from "vitest";
import type { Changes, Event, LiveSnapshot, Waypoint } from "../src/api/types";
import { EVENTS_KEPT, fromSnapshot, merge } from "../src/live/merge";

const waypoint = (id: string, x = 0): Waypoint => ({ id, area: "camp", x, y: 0, radius_m: 0.15, yaw: null });
const event = (stamp_ns: number): Event => ({ stamp_ns, level: "info", source: "olga", kind: "note", text: "" });
const snapshot = {
  type: "snapshot",
  stamp_ns: 1,
  robots: {},
  cameras: {},
  waypoints: { a: waypoint("a"), b: waypoint("b") },
  routes: {},
  objects: {},
  zones: {},
  speed_zones: {},
  estop: { engaged: false, epoch: 0, stamp_ns: 0, by: "", reason: "" },
  obstacles: null,
  health: { state: "ok" } as LiveSnapshot["health"],
  events: [event(1)],
} satisfies LiveSnapshot;
const changes = (parts: Partial<Changes>): Changes => ({ type: "changes", stamp_ns: 2, ...parts });

describe("merging changes into a snapshot", () => {
  it("changes what is there, adds what is new and removes what is null", () => {
    const state = merge(
      fromSnapshot(snapshot),
      changes({ waypoints: { a: waypoint("a", 5), b: null, c: waypoint("c") } }),
    );
    expect(Object.keys(state.waypoints).sort()).toEqual(["a", "c"]);
    expect(state.waypoints["a"]?.x).toBe(5);
  });

  it("keeps absent sections as the same objects, so that nothing is drawn again for them", () => {
    const before = fromSnapshot(snapshot);
    const state = merge(before, changes({ routes: {} }));
    expect(state.waypoints).toBe(before.waypoints);
    expect(state.health).toBe(before.health);
    expect(state.events).toBe(before.events);
  });

  it("keeps the unchanged entries of a changed section as the same objects", () => {
    const before = fromSnapshot(snapshot);
    const state = merge(before, changes({ waypoints: { a: waypoint("a", 5) } }));
    expect(state.waypoints["b"]).toBe(before.waypoints["b"]);
  });

  it("takes singles, and null as gone", () => {
    const obstacles = { stamp_ns: 2 } as LiveSnapshot["obstacles"];
    const with_ = merge(fromSnapshot(snapshot), changes({ obstacles }));
    expect(with_.obstacles).toBe(obstacles);
    expect(merge(with_, changes({})).obstacles).toBe(obstacles);
    expect(merge(with_, changes({ obstacles: null })).obstacles).toBeNull();
  });

  it("does not change the state that it started from", () => {
    const before = fromSnapshot(snapshot);
    merge(before, changes({ waypoints: { a: null } }));
    expect(before.waypoints["a"]).toBeDefined();
  });

  it("appends events and forgets the oldest beyond its limit", () => {
    const many = Array.from({ length: EVENTS_KEPT }, (_, index) => event(index + 2));
    const { events } = merge(fromSnapshot(snapshot), changes({ events: many }));
    expect(events).toHaveLength(EVENTS_KEPT);
    expect(events[0]?.stamp_ns).toBe(2);
  });
});
