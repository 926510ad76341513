/** What robots are to do: routes, the path ahead, the temporary waypoint and the obstacle box. */
import type { Point } from "../../geometry/points";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";

const ARROW_PX = 9;
const ARROW_EVERY_PX = 110;

/** A route as a line through its waypoints with arrows in the direction of travel. */
export function paintRoute(pen: Pen, points: readonly Point[], isLoop: boolean, color: string, isBold: boolean): void {
  const first = points[0];
  if (!first || points.length < 2) return;
  const line = isLoop ? [...points, first] : points;
  pen.line(line, color, isBold ? 2.5 : 1.5, isBold ? [] : [6, 5]);
  line.slice(1).forEach((to, index) => {
    const from = line[index];
    if (from) paintArrows(pen, from, to, color);
  });
}

function paintArrows(pen: Pen, [ax, ay]: Point, [bx, by]: Point, color: string): void {
  const lengthPx = Math.hypot(bx - ax, by - ay) * pen.pixelsPerMetre;
  const count = Math.max(1, Math.floor(lengthPx / ARROW_EVERY_PX));
  if (lengthPx < 3 * ARROW_PX) return;
  const angle = Math.atan2(by - ay, bx - ax);
  for (let index = 0; index < count; index += 1) {
    const share = (index + 0.5) / count;
    const x = ax + (bx - ax) * share;
    const y = ay + (by - ay) * share;
    const corner = (turn: number): Point => [
      x + (Math.cos(angle + turn) * ARROW_PX * 0.7) / pen.pixelsPerMetre,
      y + (Math.sin(angle + turn) * ARROW_PX * 0.7) / pen.pixelsPerMetre,
    ];
    pen.fill([corner(0), corner(2.5), corner(-2.5)], color);
  }
}

export interface BoxView {
  readonly outline: readonly Point[];
  readonly isBlocked: boolean;
  /** Why it is blocked. */
  readonly why: string;
  readonly blockage: Point | null;
}

/** The obstacle box: blue while it is clear, red with the reason while something is in it. */
export function paintBox(pen: Pen, palette: Palette, { outline, isBlocked, why, blockage }: BoxView): void {
  if (outline.length < 3) return;
  pen.fill(outline, isBlocked ? palette.blockedFill : palette.boxFill);
  pen.outline(outline, isBlocked ? palette.blocked : palette.box, isBlocked ? 2 : 1.5);
  if (!isBlocked) return;
  if (blockage) pen.ring(blockage, 7, palette.blocked, 2);
  const xs = outline.map(([x]) => x);
  const top: Point = [(Math.min(...xs) + Math.max(...xs)) / 2, Math.max(...outline.map(([, y]) => y))];
  pen.chip(top, -13, why, "#ffffff", palette.blocked);
}

export function paintCarrot(pen: Pen, palette: Palette, carrot: Point): void {
  pen.disc(carrot, 4.5, palette.waypoint);
  pen.ring(carrot, 7.5, palette.waypoint, 1.5);
}
