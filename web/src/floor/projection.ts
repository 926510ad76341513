/** The floor's own plane for OpenLayers: metres, x to the right, y up; no globe involved. */
import { Projection } from "ol/proj";

export const floorProjection = new Projection({
  code: "lilliput:floor",
  units: "m",
  metersPerUnit: 1,
  axisOrientation: "enu",
  global: false,
  getPointResolution: (resolution) => resolution,
});
