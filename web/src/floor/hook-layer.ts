/** A layer of the map that is painted by a function. It shares the canvas of the layers around it, which keeps it cheap. */
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { Pen } from "./Pen";

export function hookLayer(zIndex: number, paint: (pen: Pen) => void): VectorLayer {
  const layer = new VectorLayer({ source: new VectorSource(), zIndex });
  layer.on("postrender", (event) => paint(new Pen(event)));
  return layer;
}
