/** Changes of the floor made on the map: waypoints and simulated objects are placed, moved and removed; robots are sent. */
import { act } from "../api/action";
import { call } from "../api/client";
import type { LabView, RobotView, SimulatedObject, Waypoint } from "../api/types";
import { isAssigned } from "../fleet/robot-state";
import { contains, type Point } from "../geometry/points";
import { liveStore } from "../live/store";
import { offerUndo } from "./undo";

const RADIUS_M = 0.15;

/** The first of wp-1, wp-2, ... that is free. */
export function freeId(prefix: string, taken: Readonly<Record<string, unknown>>): string {
  for (let number = 1; ; number += 1) {
    const id = `${prefix}-${number}`;
    if (!(id in taken)) return id;
  }
}

/** The area around a point; outside every area the first one, so that the server can say what is wrong. */
export function areaAt(lab: LabView, point: Point): string {
  const area = lab.areas.find(({ outline }) => contains(outline, point)) ?? lab.areas[0];
  return area?.id ?? "";
}

function millimetres(value: number): number {
  return Math.round(value * 1000) / 1000;
}

function waypointAt(lab: LabView, id: string, [x, y]: Point): Waypoint {
  return { id, area: areaAt(lab, [x, y]), x: millimetres(x), y: millimetres(y), radius_m: RADIUS_M, yaw: null };
}

export async function addWaypoint(lab: LabView, point: Point): Promise<void> {
  const waypoint = waypointAt(lab, freeId("wp", liveStore.getState().state.waypoints), point);
  const done = await act("Placing a waypoint", () => call("post", "/api/waypoints", { body: waypoint }));
  if (done) offerUndo(`Waypoint ${waypoint.id} placed`, () => removeWaypoint(waypoint));
}

export function removeWaypoint({ id }: Waypoint): Promise<boolean> {
  return act(`Deleting waypoint ${id}`, () =>
    call("delete", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: id } }),
  );
}

export function putWaypoint(waypoint: Waypoint): Promise<boolean> {
  return act(`Changing waypoint ${waypoint.id}`, () =>
    call("put", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: waypoint.id }, body: waypoint }),
  );
}

export async function moveWaypoint(lab: LabView, waypoint: Waypoint, x: number, y: number): Promise<boolean> {
  const done = await putWaypoint({ ...waypoint, x, y, area: areaAt(lab, [x, y]) });
  if (done) offerUndo(`Waypoint ${waypoint.id} moved`, () => putWaypoint(waypoint));
  return done;
}

export function addObject(kind: SimulatedObject["kind"], [x, y]: Point): Promise<boolean> {
  const id = freeId(kind, liveStore.getState().state.objects);
  const body = { id, kind, x: millimetres(x), y: millimetres(y), yaw: 0, path: [], speed_mps: 0 };
  return act(`Putting down ${id}`, () => call("post", "/api/sim/objects", { body }));
}

export function moveObject(object: SimulatedObject, x: number, y: number): Promise<boolean> {
  return act(`Moving ${object.id}`, () =>
    call("put", "/api/sim/objects/{object_id}", {
      path: { object_id: object.id },
      body: { ...object, x, y, path: [] },
    }),
  );
}

export function removeObject({ id }: SimulatedObject): Promise<boolean> {
  return act(`Removing ${id}`, () => call("delete", "/api/sim/objects/{object_id}", { path: { object_id: id } }));
}

/** Sends a robot to a point: a waypoint and a route of one leg of its own, replaced each time. Stops what it drives. */
export async function sendRobot(lab: LabView, robot: RobotView, point: Point): Promise<boolean> {
  const id = `go-${robot.id}`.slice(0, 32);
  const path = { robot_id: robot.id };
  return act(`Sending ${robot.id}`, async () => {
    if (isAssigned(robot)) await call("delete", "/api/robots/{robot_id}/assignment", { path });
    await call("put", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: id }, body: waypointAt(lab, id, point) });
    const route = { id, legs: [{ waypoint: id, speed_mps: 0.3 }], loop: false };
    await call("put", "/api/routes/{route_id}", { path: { route_id: id }, body: route });
    await call("put", "/api/robots/{robot_id}/assignment", { path, body: { route: id, speed_scale: 1 } });
  });
}
