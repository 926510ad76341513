/** The API's types, all generated; where the console needs another shape it is derived from them here. */
import type { LiveChanges, LiveSnapshot } from "./schema.gen";

export type * from "./schema.gen";

/** What a message of changes carries: any part may be absent. */
export type Changes = Pick<LiveChanges, "type" | "stamp_ns"> & Partial<LiveChanges>;
export type LiveMessage = LiveSnapshot | Changes;

type Told =
  "robots" | "cameras" | "waypoints" | "routes" | "objects" | "zones" | "speed_zones" | "obstacles" | "events";

/** What is known of the lab; `estop` and `health` are null before the first message. */
export type LiveState = Readonly<Pick<LiveSnapshot, Told>> & {
  readonly estop: LiveSnapshot["estop"] | null;
  readonly health: LiveSnapshot["health"] | null;
};
