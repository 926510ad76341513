import { describe, expect, it } from "vitest";
import { Motion } from "../src/geometry/motion";
import { contains, interpolatePose, polygonToMap, toMap, wrapAngle, type Point } from "../src/geometry/points";
import { occupiedRuns } from "../src/geometry/raster";

const square: Point[] = [
  [0, 0],
  [2, 0],
  [2, 2],
  [0, 2],
];

describe("angles and poses", () => {
  it("wraps angles into (-pi, pi]", () => {
    expect(wrapAngle(3 * Math.PI)).toBeCloseTo(Math.PI);
    expect(wrapAngle(-Math.PI)).toBeCloseTo(Math.PI);
    expect(wrapAngle(-0.5)).toBeCloseTo(-0.5);
    expect(wrapAngle(7)).toBeCloseTo(7 - 2 * Math.PI);
  });

  it("maps points of a robot counter-clockwise into the map frame", () => {
    const [x, y] = toMap({ x: 1, y: 2, yaw: Math.PI / 2 }, [1, 0]);
    expect(x).toBeCloseTo(1);
    expect(y).toBeCloseTo(3);
    expect(polygonToMap({ x: 1, y: 1, yaw: 0 }, square)[2]).toEqual([3, 3]);
  });

  it("turns the short way between headings", () => {
    const half = interpolatePose({ x: 0, y: 0, yaw: 3 }, { x: 2, y: 4, yaw: -3 }, 0.5);
    expect([half.x, half.y]).toEqual([1, 2]);
    expect(Math.abs(half.yaw)).toBeCloseTo(Math.PI);
  });
});

describe("polygons", () => {
  it("tells inside from outside", () => {
    expect(contains(square, [1, 1])).toBe(true);
    expect(contains(square, [3, 1])).toBe(false);
    expect(contains(square, [1, -0.1])).toBe(false);
    expect(contains([], [0, 0])).toBe(false);
  });

  it("knows the notch of a concave one", () => {
    const notched: Point[] = [[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]]; // prettier-ignore
    expect(contains(notched, [2, 3])).toBe(false);
    expect(contains(notched, [3.5, 2])).toBe(true);
  });
});

describe("smooth motion", () => {
  const still = { x: 0, y: 0, yaw: 0 };

  it("approaches a new pose in the time between the last two", () => {
    const motion = new Motion(still, 0);
    motion.push({ x: 0.1, y: 0, yaw: 0 }, 100);
    expect(motion.at(100).x).toBeCloseTo(0);
    expect(motion.at(150).x).toBeCloseTo(0.05);
    expect(motion.at(200).x).toBeCloseTo(0.1);
    expect(motion.isMoving(199)).toBe(true);
    expect(motion.isMoving(200)).toBe(false);
  });

  it("starts from what is drawn when a pose comes early", () => {
    const motion = new Motion(still, 0);
    motion.push({ x: 0.1, y: 0, yaw: 0 }, 100);
    motion.push({ x: 0.2, y: 0, yaw: 0 }, 150);
    expect(motion.at(150).x).toBeCloseTo(0.05);
    expect(motion.at(1000).x).toBeCloseTo(0.2);
  });

  it("does not slide a robot that was carried across the floor", () => {
    const motion = new Motion(still, 0);
    motion.push({ x: 3, y: 0, yaw: 0 }, 100);
    expect(motion.at(100).x).toBe(3);
    expect(motion.isMoving(100)).toBe(false);
  });

  it("catches up within 200 ms after a long silence", () => {
    const motion = new Motion(still, 0);
    motion.push({ x: 0.1, y: 0, yaw: 0 }, 60_000);
    expect(motion.isMoving(60_199)).toBe(true);
    expect(motion.isMoving(60_200)).toBe(false);
  });

  it("rests while the same pose is repeated", () => {
    const motion = new Motion(still, 0);
    motion.push({ ...still }, 100);
    expect(motion.isMoving(101)).toBe(false);
  });
});

describe("obstacle rasters", () => {
  const raster = (rows: string[]) => {
    const bits = rows.join("").padEnd(Math.ceil(rows.join("").length / 8) * 8, "0");
    const bytes = bits.match(/.{8}/g)?.map((byte) => String.fromCharCode(parseInt(byte, 2))) ?? [];
    return {
      origin_x: 1,
      origin_y: 2,
      cell_m: 0.5,
      columns: rows[0]?.length ?? 0,
      rows: rows.length,
      occupied: btoa(bytes.join("")),
    };
  };

  it("joins neighbours of a row; rows grow with y", () => {
    expect(occupiedRuns(raster(["01101", "00000", "11111"]))).toEqual([
      [1.5, 2, 2.5, 2.5],
      [3, 2, 3.5, 2.5],
      [1, 3, 3.5, 3.5],
    ]);
  });

  it("is empty for an empty floor", () => {
    expect(occupiedRuns(raster(["000", "000"]))).toEqual([]);
  });
});
