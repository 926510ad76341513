/** A leg that only drives to its waypoint. */
import type { Leg } from "../api/types";

export function plainLeg(waypoint: string, speed_mps: number): Leg {
  return { waypoint, speed_mps, movement: "MoveTo", dwell_s: 0, confirm: false, charge_to: 0.9 };
}
