/** Draws on the map's canvas in metres: knows where a point of the floor lies on it. Sizes ending in px are CSS pixels. */
import { apply } from "ol/transform";
import type RenderEvent from "ol/render/Event";
import type { Point } from "../geometry/points";

export class Pen {
  readonly context: CanvasRenderingContext2D;
  /** CSS pixels to canvas pixels. */
  readonly ratio: number;
  /** min x, min y, max x, max y that can be seen, metres. */
  readonly extent: readonly [number, number, number, number];
  private readonly scale: number;
  private readonly originX: number;
  private readonly originY: number;

  constructor(event: RenderEvent) {
    const { frameState, inversePixelTransform, context } = event;
    if (!frameState || !inversePixelTransform || !(context instanceof CanvasRenderingContext2D))
      throw new Error("the map is not drawn on a canvas");
    const locate = (point: number[]): number[] =>
      apply(inversePixelTransform, apply(frameState.coordinateToPixelTransform, point));
    const [originX = 0, originY = 0] = locate([0, 0]);
    const [unitX = 1] = locate([1, 0]);
    this.context = context;
    this.ratio = frameState.pixelRatio;
    this.scale = unitX - originX;
    this.originX = originX;
    this.originY = originY;
    const [minX = 0, minY = 0, maxX = 0, maxY = 0] = frameState.extent ?? [];
    this.extent = [minX, minY, maxX, maxY];
  }

  /** CSS pixels per metre. */
  get pixelsPerMetre(): number {
    return this.scale / this.ratio;
  }

  x(x: number): number {
    return this.originX + x * this.scale;
  }

  y(y: number): number {
    return this.originY - y * this.scale;
  }

  px(size: number): number {
    return size * this.ratio;
  }

  fill(points: readonly Point[], color: string): void {
    this.trace(points);
    this.context.closePath();
    this.context.fillStyle = color;
    this.context.fill();
  }

  outline(points: readonly Point[], color: string, widthPx: number, dashPx: readonly number[] = []): void {
    this.trace(points);
    this.context.closePath();
    this.stroke(color, widthPx, dashPx);
  }

  line(points: readonly Point[], color: string, widthPx: number, dashPx: readonly number[] = []): void {
    this.trace(points);
    this.stroke(color, widthPx, dashPx);
  }

  disc([x, y]: Point, radiusPx: number, color: string): void {
    this.context.beginPath();
    this.context.arc(this.x(x), this.y(y), this.px(radiusPx), 0, 2 * Math.PI);
    this.context.fillStyle = color;
    this.context.fill();
  }

  ring([x, y]: Point, radiusPx: number, color: string, widthPx: number): void {
    this.context.beginPath();
    this.context.arc(this.x(x), this.y(y), this.px(radiusPx), 0, 2 * Math.PI);
    this.stroke(color, widthPx);
  }

  /** Text on a plate, centred below a point of the floor by `belowPx`. */
  chip([x, y]: Point, belowPx: number, text: string, color: string, plate: string): void {
    const { context } = this;
    context.font = `600 ${this.px(11.5)}px system-ui, "DejaVu Sans", sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const width = context.measureText(text).width + this.px(10);
    const height = this.px(17);
    const centreX = Math.round(this.x(x));
    const centreY = Math.round(this.y(y) + this.px(belowPx));
    context.beginPath();
    context.roundRect(centreX - width / 2, centreY - height / 2, width, height, this.px(3));
    context.fillStyle = plate;
    context.fill();
    context.fillStyle = color;
    context.fillText(text, centreX, centreY + this.px(0.5));
  }

  private trace(points: readonly Point[]): void {
    this.context.beginPath();
    points.forEach(([x, y], index) => {
      if (index === 0) this.context.moveTo(this.x(x), this.y(y));
      else this.context.lineTo(this.x(x), this.y(y));
    });
  }

  private stroke(color: string, widthPx: number, dashPx: readonly number[] = []): void {
    this.context.setLineDash(dashPx.map((length) => this.px(length)));
    this.context.strokeStyle = color;
    this.context.lineWidth = this.px(widthPx);
    this.context.lineJoin = "round";
    this.context.stroke();
    this.context.setLineDash([]);
  }
}
