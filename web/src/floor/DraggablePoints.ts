/**
 * Things on the map that a person may drag: waypoints and simulated objects. A dropped thing stays where it was dropped
 * until the live state follows, and goes back when the server refuses.
 */
import Feature from "ol/Feature";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import PointGeometry from "ol/geom/Point";
import PointerInteraction from "ol/interaction/Pointer";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import type Style from "ol/style/Style";
import type { Point } from "../geometry/points";

export interface Placed {
  readonly id: string;
  readonly x: number;
  readonly y: number;
}

export interface DraggableOptions<T> {
  readonly zIndex: number;
  readonly style: (thing: T, resolution: number) => Style[];
  /** How far from its centre a thing can be grabbed, metres. */
  readonly reach: (thing: T, resolution: number) => number;
  /** Asks the server to move it; false when it refused. */
  readonly onMove: (thing: T, x: number, y: number) => Promise<boolean>;
}

type PointFeature = Feature<PointGeometry>;

export class DraggablePoints<T extends Placed> {
  readonly layer: VectorLayer;
  /** Add it to the map to let things be dragged. */
  readonly interaction: PointerInteraction;
  private readonly source = new VectorSource<PointFeature>();
  private things: Readonly<Record<string, T>> = {};
  private dragged: { readonly id: string; isMoved: boolean } | null = null;
  /** What was dropped and not confirmed yet, as it was before. */
  private readonly unconfirmed = new Map<string, T>();

  constructor(private readonly options: DraggableOptions<T>) {
    this.layer = new VectorLayer({
      source: this.source,
      zIndex: options.zIndex,
      updateWhileAnimating: true,
      updateWhileInteracting: true,
      style: (feature, resolution) => {
        const thing = this.things[String(feature.getId())];
        return thing ? options.style(thing, resolution) : [];
      },
    });
    this.interaction = new PointerInteraction({
      handleDownEvent: (event: MapBrowserEvent) =>
        this.layer.getVisible() && isMainButton(event) && this.grab(...at(event)),
      handleDragEvent: (event: MapBrowserEvent) => this.drag(at(event)[0]),
      handleUpEvent: () => {
        void this.drop();
        return false;
      },
    });
  }

  update(things: Readonly<Record<string, T>>): void {
    if (things === this.things) return;
    const before = this.things;
    this.things = things;
    for (const id of Object.keys(before)) if (!things[id]) this.remove(id);
    for (const thing of Object.values(things)) if (before[thing.id] !== thing) this.show(thing);
    this.source.changed();
  }

  /** Draws again, as after a change of colours. */
  restyle(): void {
    this.source.changed();
  }

  /** The nearest thing that can be grabbed at a point of the floor. */
  at([x, y]: Point, resolution: number): T | null {
    let nearest: T | null = null;
    let smallest = Infinity;
    for (const thing of Object.values(this.things)) {
      const distance = Math.hypot(thing.x - x, thing.y - y);
      if (distance > this.options.reach(thing, resolution) || distance >= smallest) continue;
      nearest = thing;
      smallest = distance;
    }
    return nearest;
  }

  /** Begins to drag what is there; false when nothing is. */
  grab(point: Point, resolution: number): boolean {
    const thing = this.at(point, resolution);
    this.dragged = thing && { id: thing.id, isMoved: false };
    return thing !== null;
  }

  drag([x, y]: Point): void {
    if (!this.dragged) return;
    this.dragged.isMoved = true;
    this.geometry(this.dragged.id)?.setCoordinates([x, y]);
  }

  /** Leaves what is dragged where it is, and has it moved there. */
  async drop(): Promise<void> {
    const { dragged } = this;
    this.dragged = null;
    const thing = dragged?.isMoved ? this.things[dragged.id] : undefined;
    if (!thing) return;
    const [x = thing.x, y = thing.y] = this.geometry(thing.id)?.getCoordinates() ?? [];
    this.unconfirmed.set(thing.id, thing);
    if (await this.options.onMove(thing, round(x), round(y))) return;
    this.unconfirmed.delete(thing.id);
    const now = this.things[thing.id];
    if (now) this.show(now);
  }

  private show(thing: T): void {
    if (this.dragged?.id === thing.id || this.unconfirmed.get(thing.id) === thing) return;
    this.unconfirmed.delete(thing.id);
    const geometry = this.geometry(thing.id);
    if (geometry) {
      geometry.setCoordinates([thing.x, thing.y]);
      return;
    }
    const added = new Feature(new PointGeometry([thing.x, thing.y]));
    added.setId(thing.id);
    this.source.addFeature(added);
  }

  private remove(id: string): void {
    const feature = this.source.getFeatureById(id);
    if (feature instanceof Feature) this.source.removeFeature(feature);
    this.unconfirmed.delete(id);
  }

  /** Where a thing is drawn. */
  geometry(id: string): PointGeometry | null {
    const feature = this.source.getFeatureById(id);
    return feature instanceof Feature ? (feature.getGeometry() ?? null) : null;
  }
}

function at(event: MapBrowserEvent): [point: Point, resolution: number] {
  const [x = 0, y = 0] = event.coordinate;
  return [[x, y], event.map.getView().getResolution() ?? 0.01];
}

function isMainButton({ originalEvent }: MapBrowserEvent): boolean {
  return originalEvent instanceof MouseEvent && originalEvent.button === 0;
}

/** To the millimetre: what a hand does on a map is no finer. */
function round(metres: number): number {
  return Math.round(metres * 1000) / 1000;
}
