/**
 * The live state of the lab in the browser. `liveStore` follows every message (20 per second) and is for the map, which
 * draws by itself; `useLive` is for React and follows a sample of it, four times a second, so that a page of numbers costs
 * little. What a person has just done (a stop, an edited waypoint) comes through at once.
 */
import { useStore } from "zustand";
import { createStore } from "zustand/vanilla";
import { fromSnapshot, merge, NOTHING } from "./merge";
import type { LiveMessage, LiveState } from "../api/types";
import { ServerClock } from "./server-clock";
import type { Connection } from "./stream";

export interface Live {
  readonly state: LiveState;
  readonly connection: Connection;
  /** False until the first snapshot: before it, an empty list means nothing. */
  readonly known: boolean;
  /** The server's time (ms since the epoch) at this sample. */
  readonly nowMs: number;
  /** The local time at this sample. */
  readonly sampledMs: number;
}

const SAMPLE_MS = 250;
const URGENT = ["estop", "waypoints", "routes", "objects", "speed_zones", "events"] as const;

const clock = new ServerClock();
const initial: Live = {
  state: NOTHING,
  connection: { state: "connecting", sinceMs: 0 },
  known: false,
  nowMs: 0,
  sampledMs: 0,
};

export const liveStore = createStore<Live>(() => initial);
const sampledStore = createStore<Live>(() => initial);

/** A part of the sampled state; renders again only when that part changes. */
export function useLive<T>(select: (live: Live) => T): T {
  return useStore(sampledStore, select);
}

/** The server's time now, ms since the epoch. */
export function serverNowMs(): number {
  return clock.now(Date.now());
}

export function takeMessage(message: LiveMessage): void {
  clock.hear(message.stamp_ns, Date.now());
  const before = liveStore.getState().state;
  const state = message.type === "snapshot" ? fromSnapshot(message) : merge(before, message);
  liveStore.setState({ state, known: true, nowMs: serverNowMs() });
  if (URGENT.some((name) => state[name] !== before[name])) sample();
}

export function takeConnection(connection: Connection): void {
  liveStore.setState({ connection });
  sample();
}

/** Forgets everything, as after a log-out. */
export function forget(): void {
  liveStore.setState(initial);
  sample();
}

/** Starts sampling; returns what ends it. */
export function startSampling(): () => void {
  const timer = setInterval(sample, SAMPLE_MS);
  return () => clearInterval(timer);
}

function sample(): void {
  sampledStore.setState({ ...liveStore.getState(), nowMs: serverNowMs(), sampledMs: Date.now() });
}
