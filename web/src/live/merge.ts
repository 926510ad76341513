/** What the live stream has said so far: a snapshot, and the changes since merged into it. Pure. */
import type { Changes, LiveSnapshot, LiveState } from "../api/types";

export const NOTHING: LiveState = {
  robots: {},
  cameras: {},
  waypoints: {},
  routes: {},
  objects: {},
  zones: {},
  speed_zones: {},
  estop: null,
  obstacles: null,
  health: null,
  events: [],
};

/** How many of the newest events are kept. */
export const EVENTS_KEPT = 500;

/** The state that a snapshot tells. */
export function fromSnapshot(snapshot: LiveSnapshot): LiveState {
  const { robots, cameras, waypoints, routes, objects, zones, speed_zones, estop, obstacles, health, events } =
    snapshot;
  return { robots, cameras, waypoints, routes, objects, zones, speed_zones, estop, obstacles, health, events };
}

/** The state after some changes: what is absent stays (the same objects as before), what is null goes. */
export function merge(state: LiveState, changes: Changes): LiveState {
  return {
    robots: mergeSection(state.robots, changes.robots),
    cameras: mergeSection(state.cameras, changes.cameras),
    waypoints: mergeSection(state.waypoints, changes.waypoints),
    routes: mergeSection(state.routes, changes.routes),
    objects: mergeSection(state.objects, changes.objects),
    zones: mergeSection(state.zones, changes.zones),
    speed_zones: mergeSection(state.speed_zones, changes.speed_zones),
    estop: mergeSingle(state.estop, changes.estop),
    obstacles: mergeSingle(state.obstacles, changes.obstacles),
    health: mergeSingle(state.health, changes.health),
    events: changes.events?.length ? [...state.events, ...changes.events].slice(-EVENTS_KEPT) : state.events,
  };
}

type Section<T> = Readonly<Record<string, T>>;

function mergeSection<T>(section: Section<T>, changes: Section<T | null> | undefined): Record<string, T> {
  if (changes === undefined) return section;
  const merged: Record<string, T> = { ...section };
  for (const [id, value] of Object.entries(changes)) {
    if (value === null) Reflect.deleteProperty(merged, id);
    else merged[id] = value;
  }
  return merged;
}

function mergeSingle<T>(single: T | null, change: T | null | undefined): T | null {
  return change === undefined ? single : change;
}
