/** Keeps the stitched picture of the floor fresh: fetched now and then while it is shown, decoded away from the map. */
import type { Rectangle } from "../geometry/raster";
import type { Picture } from "./paint/ground";

const EVERY_MS = 5000;

export class FloorPicture {
  picture: Picture | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private tag: string | null = null;
  private running = false;

  constructor(private readonly onChange: () => void) {}

  start(): void {
    if (this.running) return;
    this.running = true;
    void this.refresh();
  }

  stop(): void {
    this.running = false;
    clearTimeout(this.timer);
  }

  dispose(): void {
    this.stop();
    this.picture?.image.close();
    this.picture = null;
  }

  private async refresh(): Promise<void> {
    if (!document.hidden) await this.fetchPicture();
    if (this.running) this.timer = setTimeout(() => void this.refresh(), EVERY_MS);
  }

  /** A floor without a picture yet is drawn without one; the health says which camera is missing. */
  private async fetchPicture(): Promise<void> {
    try {
      const response = await fetch("/api/floor.jpg", { cache: "no-cache" });
      const bounds = parseBounds(response.headers.get("X-Bounds"));
      const tag = response.headers.get("ETag");
      if (!response.ok || !bounds || (tag !== null && tag === this.tag)) return;
      const image = await createImageBitmap(await response.blob());
      this.picture?.image.close();
      this.picture = { image, bounds };
      this.tag = tag;
      if (this.running) this.onChange();
    } catch {
      // The server is away or the picture is broken; the next round tries again.
    }
  }
}

/** The header `X-Bounds: minx,miny,maxx,maxy`; null when it is missing or not four numbers that span an area. */
export function parseBounds(header: string | null): Rectangle | null {
  const [minX = NaN, minY = NaN, maxX = NaN, maxY = NaN, ...rest] = (header ?? "").split(",").map(Number);
  return rest.length === 0 && maxX > minX && maxY > minY ? [minX, minY, maxX, maxY] : null;
}
