/** What the cameras see on the floor that should not be there: red cells. */
import type { Rectangle } from "../../geometry/raster";
import type { Palette } from "../palette";
import type { Pen } from "../Pen";

export function paintObstacles(pen: Pen, palette: Palette, cells: readonly Rectangle[]): void {
  const { context } = pen;
  context.beginPath();
  for (const [minX, minY, maxX, maxY] of cells)
    context.rect(pen.x(minX), pen.y(maxY), pen.x(maxX) - pen.x(minX), pen.y(minY) - pen.y(maxY));
  context.fillStyle = palette.obstacle;
  context.fill();
}
