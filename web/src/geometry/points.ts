/** Plane geometry of the floor: metres in the map frame, radians counter-clockwise. */

export type Point = readonly [x: number, y: number];

export interface Pose {
  readonly x: number;
  readonly y: number;
  readonly yaw: number;
}

/** The angle in (-pi, pi]. */
export function wrapAngle(angle: number): number {
  const turn = 2 * Math.PI;
  const wrapped = angle - turn * Math.floor((angle + Math.PI) / turn);
  return wrapped === -Math.PI ? Math.PI : wrapped;
}

/** A point given in the frame of `pose`, in the map frame. */
export function toMap(pose: Pose, [x, y]: Point): Point {
  const cos = Math.cos(pose.yaw);
  const sin = Math.sin(pose.yaw);
  return [pose.x + cos * x - sin * y, pose.y + sin * x + cos * y];
}

/** A polygon given in the frame of `pose`, in the map frame. */
export function polygonToMap(pose: Pose, polygon: readonly Point[]): Point[] {
  return polygon.map((point) => toMap(pose, point));
}

/** Between two poses; the heading turns the short way. `share` 0 gives the first, 1 the second. */
export function interpolatePose(from: Pose, to: Pose, share: number): Pose {
  return {
    x: from.x + (to.x - from.x) * share,
    y: from.y + (to.y - from.y) * share,
    yaw: wrapAngle(from.yaw + wrapAngle(to.yaw - from.yaw) * share),
  };
}

/** Whether the point lies inside the polygon (even-odd rule). */
export function contains(polygon: readonly Point[], [x, y]: Point): boolean {
  let inside = false;
  polygon.forEach(([ax, ay], index) => {
    const [bx, by] = polygon[(index + polygon.length - 1) % polygon.length] ?? [ax, ay];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  });
  return inside;
}
