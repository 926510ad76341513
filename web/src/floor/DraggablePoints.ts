/**
 * Things on the map that a person may drag: waypoints and simulated objects. A dropped thing stays where it was dropped
 * until the live state follows, and goes back when the server refuses.
 */
import Collection from "ol/Collection";
import Feature from "ol/Feature";
import PointGeometry from "ol/geom/Point";
import Translate from "ol/interaction/Translate";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import type Style from "ol/style/Style";

export interface Placed {
  readonly id: string;
  readonly x: number;
  readonly y: number;
}

export interface DraggableOptions<T> {
  readonly zIndex: number;
  readonly style: (thing: T, resolution: number) => Style[];
  /** Asks the server to move it; false when it refused. */
  readonly onMove: (thing: T, x: number, y: number) => Promise<boolean>;
}

type PointFeature = Feature<PointGeometry>;

export class DraggablePoints<T extends Placed> {
  readonly layer: VectorLayer;
  readonly drag: Translate;
  private readonly source = new VectorSource<PointFeature>();
  private readonly features = new Collection<PointFeature>();
  private things: Readonly<Record<string, T>> = {};
  /** What was dropped and not confirmed yet, as it was before. */
  private readonly unconfirmed = new Map<string, T | null>();

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
    this.drag = new Translate({ features: this.features, hitTolerance: 6 });
    this.drag.on("translatestart", (event) => event.features.forEach((feature) => this.begin(feature)));
    this.drag.on("translateend", (event) => event.features.forEach((feature) => void this.drop(feature)));
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

  /** The thing that a feature found on the map stands for. */
  thing(feature: unknown): T | null {
    return feature instanceof Feature ? (this.things[String(feature.getId())] ?? null) : null;
  }

  private show(thing: T): void {
    const before = this.unconfirmed.get(thing.id);
    if (before === null || before === thing) return;
    this.unconfirmed.delete(thing.id);
    const feature = this.source.getFeatureById(thing.id);
    if (feature instanceof Feature) {
      feature.getGeometry()?.setCoordinates([thing.x, thing.y]);
      return;
    }
    const added = new Feature(new PointGeometry([thing.x, thing.y]));
    added.setId(thing.id);
    this.source.addFeature(added);
    this.features.push(added);
  }

  private remove(id: string): void {
    const feature = this.features.getArray().find((candidate) => candidate.getId() === id);
    if (!feature) return;
    this.source.removeFeature(feature);
    this.features.remove(feature);
    this.unconfirmed.delete(id);
  }

  private begin(feature: Feature): void {
    this.unconfirmed.set(String(feature.getId()), null);
  }

  private async drop(feature: Feature): Promise<void> {
    const geometry = feature.getGeometry();
    const thing = this.thing(feature);
    if (!thing || !(geometry instanceof PointGeometry)) return;
    const [x = thing.x, y = thing.y] = geometry.getCoordinates();
    this.unconfirmed.set(thing.id, thing);
    if (await this.options.onMove(thing, round(x), round(y))) return;
    this.unconfirmed.delete(thing.id);
    const now = this.things[thing.id];
    if (now) geometry.setCoordinates([now.x, now.y]);
  }
}

/** To the millimetre: what a hand does on a map is no finer. */
function round(metres: number): number {
  return Math.round(metres * 1000) / 1000;
}
