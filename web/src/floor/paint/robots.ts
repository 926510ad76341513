/** Robots: their footprint with a nose that shows the heading, and a plate with the id; faded while the pose is stale. */
import { polygonToMap, toMap, type Point, type Pose } from "../../geometry/points";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";

export interface RobotMark {
  readonly id: string;
  readonly footprint: readonly Point[];
  readonly color: string;
  readonly label: string;
  readonly isStale: boolean;
  readonly isSelected: boolean;
}

const SMALLEST_PX = 14;

/** The footprint, enlarged when it would be too small to see or to hit on a map zoomed far out. */
export function visibleFootprint(footprint: readonly Point[], pixelsPerMetre: number): Point[] {
  const reach = Math.max(0.01, ...footprint.map(([x, y]) => Math.hypot(x, y)));
  const factor = Math.max(1, SMALLEST_PX / (reach * pixelsPerMetre));
  return footprint.map(([x, y]) => [x * factor, y * factor]);
}

export function paintRobot(pen: Pen, palette: Palette, mark: RobotMark, pose: Pose): void {
  const footprint = visibleFootprint(mark.footprint, pen.pixelsPerMetre);
  const outline = polygonToMap(pose, footprint);
  const { context } = pen;
  context.save();
  if (mark.isStale) context.globalAlpha = 0.45;
  if (mark.isSelected) pen.outline(outline, palette.chipText, 7);
  pen.outline(outline, "#ffffff", 3.5);
  pen.fill(outline, mark.color);
  if (mark.isStale) pen.outline(outline, palette.chipText, 1.5, [3, 3]);
  paintNose(pen, footprint, pose);
  context.restore();
  const lowest = Math.min(...outline.map(([, y]) => y));
  const below = (pose.y - lowest) * pen.pixelsPerMetre + 14;
  pen.chip([pose.x, pose.y], below, mark.label, mark.isStale ? palette.blocked : palette.chipText, palette.chip);
}

function paintNose(pen: Pen, footprint: readonly Point[], pose: Pose): void {
  const front = Math.max(...footprint.map(([x]) => x));
  const half = Math.max(...footprint.map(([, y]) => y)) * 0.62;
  const nose: Point[] = [
    [front * 0.82, 0],
    [-front * 0.35, half],
    [-front * 0.1, 0],
    [-front * 0.35, -half],
  ];
  pen.fill(
    nose.map((point) => toMap(pose, point)),
    "#ffffff",
  );
}
