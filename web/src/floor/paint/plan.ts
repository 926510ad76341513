/** What the lab description says of the floor: areas, zones, and where the cameras look. */
import type { LabView, SpeedZone } from "../../api/types";
import type { Point } from "../../geometry/points";
import { formatSpeed } from "../../ui/format";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";

export function paintAreas(pen: Pen, palette: Palette, lab: LabView): void {
  for (const area of lab.areas) pen.outline(area.outline, palette.area, 1.5);
}

export function paintZones(pen: Pen, palette: Palette, lab: LabView): void {
  for (const zone of lab.zones) {
    const subareas = Object.values(zone.subareas);
    for (const outline of subareas) {
      pen.fill(outline, palette.zoneFill);
      pen.outline(outline, palette.zone, 1, [4, 3]);
    }
    const top = highest(subareas.flat());
    if (top && pen.pixelsPerMetre > 40) pen.chip(top, -12, zone.id, palette.zone, palette.chip);
  }
}

/** Where robots drive no faster than the zone's limit, which is written on it. */
export function paintSpeedZones(pen: Pen, palette: Palette, zones: readonly SpeedZone[]): void {
  for (const { outline, speed_mps } of zones) {
    pen.fill(outline, palette.speedFill);
    pen.outline(outline, palette.speed, 1.5);
    const top = highest(outline);
    if (top) pen.chip(top, 12, `≤ ${formatSpeed(speed_mps)}`, palette.speed, palette.chip);
  }
}

/** Middle of the upper edge of some points. */
function highest(points: readonly Point[]): Point | null {
  if (points.length === 0) return null;
  const xs = points.map(([x]) => x);
  return [(Math.min(...xs) + Math.max(...xs)) / 2, Math.max(...points.map(([, y]) => y))];
}

export interface FieldOfView {
  readonly id: string;
  readonly outline: readonly Point[];
  readonly isWorking: boolean;
}

export function paintFieldsOfView(pen: Pen, palette: Palette, fields: readonly FieldOfView[]): void {
  for (const { id, outline, isWorking } of fields) {
    const color = isWorking ? palette.camera : palette.blocked;
    pen.outline(outline, color, 1.5, [8, 5]);
    const top = highest(outline);
    if (top) pen.chip(top, 14, isWorking ? id : `${id}: no picture`, color, palette.chip);
  }
}
