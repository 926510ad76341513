/** Occupied cells of a floor raster (row-major bits, most significant first) as rectangles in metres, map frame. */

export interface Raster {
  readonly origin_x: number;
  readonly origin_y: number;
  readonly cell_m: number;
  readonly columns: number;
  readonly rows: number;
  /** Base64 of the packed bits. */
  readonly occupied: string;
}

/** min x, min y, max x, max y. */
export type Rectangle = readonly [number, number, number, number];

/** One rectangle per run of occupied cells in a row: far fewer shapes to draw than cells. */
export function occupiedRuns(raster: Raster): Rectangle[] {
  const bits = atob(raster.occupied);
  const isOccupied = (cell: number) => ((bits.charCodeAt(cell >> 3) >> (7 - (cell & 7))) & 1) === 1;
  const runs: Rectangle[] = [];
  for (let row = 0; row < raster.rows; row += 1) {
    const y = raster.origin_y + row * raster.cell_m;
    let start = -1;
    for (let column = 0; column <= raster.columns; column += 1) {
      const occupied = column < raster.columns && isOccupied(row * raster.columns + column);
      if (occupied && start < 0) start = column;
      if (!occupied && start >= 0) {
        runs.push([
          raster.origin_x + start * raster.cell_m,
          y,
          raster.origin_x + column * raster.cell_m,
          y + raster.cell_m,
        ]);
        start = -1;
      }
    }
  }
  return runs;
}
