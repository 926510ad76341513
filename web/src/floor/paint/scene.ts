/** The order in which the floor is painted: the room below, what moves above the waypoints. */
import type { LabView, LiveState } from "../../api/types";
import type { Point } from "../../geometry/points";
import type { Rectangle } from "../../geometry/raster";
import { serverNowMs } from "../../live/store";
import type { LayerName } from "../floor-state";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";
import type { RobotMarks } from "../RobotMarks";
import { paintGrid, paintGridLabels, paintPicture, paintScaleBar, type Picture } from "./ground";
import { paintObstacles } from "./obstacles";
import { paintBox, paintCarrot, paintRoute } from "./orders";
import { paintAreas, paintFieldsOfView, paintSpeedZones, paintZones } from "./plan";
import { paintRobot } from "./robots";

type Shown = Readonly<Record<LayerName, boolean>>;

export interface FloorScene {
  readonly palette: Palette;
  readonly lab: LabView | null;
  readonly picture: Picture | null;
  readonly state: LiveState;
  readonly obstacles: readonly Rectangle[];
  readonly layers: Shown;
}

/** Everything that lies on the floor. */
export function paintFloor(pen: Pen, { palette, lab, picture, state, obstacles, layers }: FloorScene): void {
  if (layers.picture && picture) paintPicture(pen, picture);
  if (layers.grid) paintGrid(pen, palette);
  if (lab) paintAreas(pen, palette, lab);
  if (lab && layers.zones) paintZones(pen, palette, lab);
  if (layers.speeds) paintSpeedZones(pen, palette, Object.values(state.speed_zones));
  if (layers.cameras) {
    const fields = Object.values(state.cameras).flatMap(({ id, outline, state: camera }) =>
      outline ? { id, outline, isWorking: camera?.fresh === true && camera.error === null } : [],
    );
    paintFieldsOfView(pen, palette, fields);
  }
  if (layers.obstacles) paintObstacles(pen, palette, obstacles);
  if (layers.routes) paintRoutes(pen, palette, state);
  if (layers.grid) paintGridLabels(pen, palette);
  paintScaleBar(pen, palette);
}

function paintRoutes(pen: Pen, palette: Palette, state: LiveState): void {
  const driven = new Set(
    Object.values(state.robots).map(({ assignment }) => (assignment?.state === "running" ? assignment.route : null)),
  );
  for (const route of Object.values(state.routes)) {
    const points = route.legs.flatMap(({ waypoint }): Point[] => {
      const place = state.waypoints[waypoint];
      return place ? [[place.x, place.y]] : [];
    });
    paintRoute(pen, points, route.loop, palette.route, driven.has(route.id));
  }
}

export interface Traffic {
  readonly palette: Palette;
  readonly robots: RobotMarks;
  readonly layers: Shown;
  readonly selected: string | null;
  readonly nowMs: number;
}

/** Robots and what is in front of them. */
export function paintTraffic(pen: Pen, { palette, robots, layers, selected, nowMs }: Traffic): void {
  if (layers.routes)
    for (const { robot, path, detour } of robots.orders()) {
      if (robot === selected) pen.line(path, palette.box, 2, [2, 5]);
      if (detour.length > 1) pen.line(detour, palette.tones.waiting, 3, [10, 6]);
    }
  if (layers.boxes) {
    for (const box of robots.boxes()) paintBox(pen, palette, box);
    for (const { carrot } of robots.orders()) if (carrot) paintCarrot(pen, palette, carrot);
  }
  for (const { mark, pose } of robots.marks(palette, selected, serverNowMs(), nowMs))
    paintRobot(pen, palette, mark, pose);
}
