/** OpenLayers styles of what can be dragged on the map. */
import CircleGeometry from "ol/geom/Circle";
import PointGeometry from "ol/geom/Point";
import { Circle, Fill, RegularShape, Stroke, Style, Text } from "ol/style";
import type { SimulatedObject, Waypoint } from "../api/types";
import type { Palette } from "./palette";

const FONT = '600 11.5px system-ui, "DejaVu Sans", sans-serif';
const SMALLEST_RADIUS_PX = 9;

function label(palette: Palette, text: string, offsetY: number, color: string): Style {
  return new Style({
    text: new Text({
      text,
      font: FONT,
      offsetY,
      padding: [1, 4, 0, 5],
      fill: new Fill({ color }),
      backgroundFill: new Fill({ color: palette.chip }),
    }),
    zIndex: 2,
  });
}

/** A circle of the waypoint's own radius, a dot, its id, and a hand for the heading to leave it with. */
export function waypointStyle(palette: Palette, waypoint: Waypoint, resolution: number): Style[] {
  const radius = Math.max(waypoint.radius_m, SMALLEST_RADIUS_PX * resolution);
  const centre = (style: Style, make: (x: number, y: number) => CircleGeometry | PointGeometry) => {
    style.setGeometry((feature) => {
      const geometry = feature.getGeometry();
      const [x = 0, y = 0] = geometry instanceof PointGeometry ? geometry.getCoordinates() : [];
      return make(x, y);
    });
    return style;
  };
  const styles = [
    centre(
      new Style({
        fill: new Fill({ color: palette.waypointFill }),
        stroke: new Stroke({ color: palette.waypoint, width: 2 }),
      }),
      (x, y) => new CircleGeometry([x, y], radius),
    ),
    new Style({ image: new Circle({ radius: 3.5, fill: new Fill({ color: palette.waypoint }) }) }),
    label(palette, waypoint.id, radius / resolution + 12, palette.chipText),
  ];
  const { yaw } = waypoint;
  if (typeof yaw === "number") {
    const tip = new Style({
      image: new RegularShape({
        points: 3,
        radius: 6,
        rotation: Math.PI / 2 - yaw,
        fill: new Fill({ color: palette.waypoint }),
      }),
    });
    styles.push(centre(tip, (x, y) => new PointGeometry([x + radius * Math.cos(yaw), y + radius * Math.sin(yaw)])));
  }
  return styles;
}

/** Simulated things: a square for a pallet, a round one for a person. */
export function objectStyle(palette: Palette, thing: SimulatedObject): Style[] {
  const fill = new Fill({ color: palette.object });
  const stroke = new Stroke({ color: "#ffffff", width: 1.5 });
  const image =
    thing.kind === "person"
      ? new Circle({ radius: 8, fill, stroke })
      : new RegularShape({ points: 4, radius: 12, angle: Math.PI / 4, rotation: -thing.yaw, fill, stroke });
  return [new Style({ image }), label(palette, thing.id, 19, palette.chipText)];
}
