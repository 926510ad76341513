/** Changes of the floor made on the map: waypoints and simulated objects are placed, moved and removed; robots are sent. */
import { act } from "../api/action";
import { ApiError, call } from "../api/client";
import type { LabView, RobotView, SimulatedObject, Waypoint } from "../api/types";
import { isAssigned } from "../fleet/robot-state";
import { contains, type Point } from "../geometry/points";
import { liveStore } from "../live/store";
import { plainLeg } from "../routes/leg";
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

/** Creates something under the first free id. Clicks can come faster than the live stream, and from several consoles: an id
 * that turns out to be taken is left for the next one. */
export async function createWithFreeId(
  prefix: string,
  taken: Readonly<Record<string, unknown>>,
  create: (id: string) => Promise<unknown>,
): Promise<string> {
  const refused: Record<string, true> = {};
  for (;;) {
    const id = freeId(prefix, { ...taken, ...refused });
    try {
      await create(id);
      return id;
    } catch (error) {
      if (!(error instanceof ApiError && error.status === 409)) throw error;
      refused[id] = true;
    }
  }
}

export async function addWaypoint(lab: LabView, point: Point): Promise<void> {
  await act("Placing a waypoint", () =>
    createWithFreeId("wp", liveStore.getState().state.waypoints, async (id) => {
      const waypoint = waypointAt(lab, id, point);
      await call("post", "/api/waypoints", { body: waypoint });
      offerUndo(`Waypoint ${id} placed`, () => removeWaypoint(waypoint));
    }),
  );
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
  return act(`Putting down a ${kind}`, () =>
    createWithFreeId(kind, liveStore.getState().state.objects, (id) =>
      call("post", "/api/sim/objects", {
        body: { id, kind, x: millimetres(x), y: millimetres(y), yaw: 0, path: [], speed_mps: 0 },
      }),
    ),
  );
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
    const route = { id, legs: [plainLeg(id, 0.3)], loop: false };
    await call("put", "/api/routes/{route_id}", { path: { route_id: id }, body: route });
    await call("put", "/api/robots/{robot_id}/assignment", { path, body: { route: id, speed_scale: 1 } });
  });
}
