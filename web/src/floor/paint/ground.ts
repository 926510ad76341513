/** The lowest things on the map: the floor picture and the grid in metres. */
import type { Rectangle } from "../../geometry/raster";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";

export interface Picture {
  readonly image: ImageBitmap;
  /** min x, min y, max x, max y in metres. */
  readonly bounds: Rectangle;
}

export function paintPicture(pen: Pen, { image, bounds: [minX, minY, maxX, maxY] }: Picture): void {
  const { context } = pen;
  context.imageSmoothingEnabled = true;
  context.drawImage(image, pen.x(minX), pen.y(maxY), pen.x(maxX) - pen.x(minX), pen.y(minY) - pen.y(maxY));
}

const SMALLEST_PITCH_PX = 36;
const PITCHES_M = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const LABEL_INSET_PX = 6;

/** A line every metre, every few metres when that would be too dense. */
export function gridPitch(pixelsPerMetre: number): number {
  return PITCHES_M.find((pitch) => pitch * pixelsPerMetre >= SMALLEST_PITCH_PX) ?? 1000;
}

export function paintGrid(pen: Pen, palette: Palette): void {
  const pitch = gridPitch(pen.pixelsPerMetre);
  const [minX, minY, maxX, maxY] = pen.extent;
  for (const x of multiples(pitch, minX, maxX)) {
    const isMajor = Math.round(x / pitch) % 5 === 0;
    pen.line([[x, minY], [x, maxY]], isMajor ? palette.gridMajor : palette.grid, 1); // prettier-ignore
  }
  for (const y of multiples(pitch, minY, maxY)) {
    const isMajor = Math.round(y / pitch) % 5 === 0;
    pen.line([[minX, y], [maxX, y]], isMajor ? palette.gridMajor : palette.grid, 1); // prettier-ignore
  }
}

/** The metres beside the grid lines, at the lower and the left border of what is seen. */
export function paintGridLabels(pen: Pen, palette: Palette): void {
  const pitch = gridPitch(pen.pixelsPerMetre);
  const [minX, minY, maxX, maxY] = pen.extent;
  const { context } = pen;
  context.font = `${pen.px(10.5)}px system-ui, "DejaVu Sans", sans-serif`;
  context.fillStyle = palette.gridText;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  for (const x of multiples(pitch, minX, maxX))
    context.fillText(`${x}`, pen.x(x) + pen.px(3), pen.y(minY) - pen.px(LABEL_INSET_PX));
  for (const y of multiples(pitch, minY, maxY))
    context.fillText(`${y}`, pen.x(minX) + pen.px(LABEL_INSET_PX), pen.y(y) - pen.px(2));
}

const BARS_M = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];
const SHORTEST_BAR_PX = 70;
const BAR_INSET_PX = 16;

/** The length of the scale bar, in metres. */
export function barLength(pixelsPerMetre: number): number {
  return BARS_M.find((length) => length * pixelsPerMetre >= SHORTEST_BAR_PX) ?? 1000;
}

/** How long a round number of metres is, in the lower right corner. */
export function paintScaleBar(pen: Pen, palette: Palette): void {
  const length = barLength(pen.pixelsPerMetre);
  const [, minY, maxX] = pen.extent;
  const inset = BAR_INSET_PX / pen.pixelsPerMetre;
  const tick = 5 / pen.pixelsPerMetre;
  const [left, right, low] = [maxX - inset - length, maxX - inset, minY + inset];
  pen.line([[left, low + tick], [left, low], [right, low], [right, low + tick]], palette.chipText, 2); // prettier-ignore
  pen.chip([(left + right) / 2, low], -11, `${length} m`, palette.chipText, palette.chip);
}

function multiples(pitch: number, from: number, to: number): number[] {
  const first = Math.ceil(from / pitch);
  const last = Math.floor(to / pitch);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => (first + index) * pitch);
}
