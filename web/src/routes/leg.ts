/** Legs: one that only drives to its waypoint, and one without what the console keeps beside it. */
import type { Leg } from "../api/types";

export function plainLeg(waypoint: string, speed_mps: number): Leg {
  return { waypoint, speed_mps, movement: "MoveTo", dwell_s: 0, confirm: false, charge_to: 0.9 };
}

export function legOf(draft: Leg): Leg {
  const { waypoint, speed_mps, movement, dwell_s, confirm, charge_to, yaw = null, action = null } = draft;
  return { waypoint, speed_mps, movement, dwell_s, confirm, charge_to, yaw, action };
}
