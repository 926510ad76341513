/** What the live stream has said so far: a snapshot, and the changes since merged into it. Pure. */
import type { LiveChanges, LiveSnapshot, LiveState } from "./messages";

const SECTIONS = ["robots", "cameras", "waypoints", "routes", "objects", "zones"] as const;
const SINGLES = ["estop", "obstacles", "health"] as const;

export const NOTHING: LiveState = {
  robots: {},
  cameras: {},
  waypoints: {},
  routes: {},
  objects: {},
  zones: {},
  estop: null,
  obstacles: null,
  health: null,
};

/** The state that a snapshot tells. */
export function fromSnapshot(snapshot: LiveSnapshot): LiveState {
  const state: Record<string, unknown> = {};
  for (const name of SECTIONS) state[name] = snapshot[name] ?? {};
  for (const name of SINGLES) state[name] = snapshot[name] ?? null;
  return state as unknown as LiveState;
}

/** The state after some changes: absent entries stay (the same objects as before), null ones go. */
export function merge(state: LiveState, changes: LiveChanges): LiveState {
  const merged: Record<string, unknown> = { ...state };
  for (const name of SECTIONS) {
    const changed = changes[name];
    if (changed !== undefined && changed !== null) merged[name] = mergeSection(state[name], changed);
  }
  for (const name of SINGLES) {
    if (changes[name] !== undefined) merged[name] = changes[name];
  }
  return merged as unknown as LiveState;
}

function mergeSection<T>(section: Readonly<Record<string, T>>, changes: Readonly<Record<string, T | null>>) {
  const merged: Record<string, T> = { ...section };
  for (const [id, value] of Object.entries(changes)) {
    if (value === null) Reflect.deleteProperty(merged, id);
    else merged[id] = value;
  }
  return merged;
}
