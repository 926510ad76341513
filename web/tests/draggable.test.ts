// @vitest-environment jsdom
import { beforeEach, describe, expect, it, vi } from "vitest";

vi.stubGlobal("ResizeObserver", vi.fn());
const { DraggablePoints } = await import("../src/floor/DraggablePoints");

interface Thing {
  readonly id: string;
  readonly x: number;
  readonly y: number;
}

const a: Thing = { id: "a", x: 1, y: 1 };
const b: Thing = { id: "b", x: 1.2, y: 1 };
let answer: (accepted: boolean) => void;
let moves: [string, number, number][];
let points: InstanceType<typeof DraggablePoints<Thing>>;
const drawn = (id: string) => points.geometry(id)?.getCoordinates();

beforeEach(() => {
  moves = [];
  points = new DraggablePoints<Thing>({
    zIndex: 1,
    style: () => [],
    reach: () => 0.15,
    onMove: ({ id }, x, y) => {
      moves.push([id, x, y]);
      return new Promise((resolve) => {
        answer = resolve;
      });
    },
  });
  points.update({ a, b });
});

describe("dragging on the map", () => {
  it("grabs the nearest thing within reach, and that one alone", async () => {
    expect(points.grab([5, 5], 0.01)).toBe(false);
    expect(points.grab([1.12, 1], 0.01)).toBe(true);
    points.drag([2.00049, 3]);
    void points.drop();
    expect(moves).toEqual([["b", 2, 3]]);
    expect(drawn("a")).toEqual([1, 1]);
    await Promise.resolve();
  });

  it("does not move what was only clicked", async () => {
    points.grab([1, 1], 0.01);
    await points.drop();
    expect(moves).toEqual([]);
  });

  it("leaves a thing where it was dropped until the live state follows", async () => {
    points.grab([1, 1], 0.01);
    points.drag([2, 2]);
    const edited = { ...a };
    points.update({ a: edited, b });
    expect(drawn("a")).toEqual([2, 2]);
    const dropped = points.drop();
    answer(true);
    await dropped;
    points.update({ a: edited, b: { ...b } });
    expect(drawn("a")).toEqual([2, 2]);
    points.update({ a: { ...a, x: 2, y: 2.5 }, b });
    expect(drawn("a")).toEqual([2, 2.5]);
  });

  it("puts it back when the server refuses", async () => {
    points.grab([1, 1], 0.01);
    points.drag([-9, 2]);
    const dropped = points.drop();
    answer(false);
    await dropped;
    expect(drawn("a")).toEqual([1, 1]);
  });

  it("takes a removed thing off the map, also while it is dragged", async () => {
    points.grab([1, 1], 0.01);
    points.update({ b });
    points.drag([2, 2]);
    expect(drawn("a")).toBeUndefined();
    expect(points.at([1, 1], 0.01)?.id).toBeUndefined();
    await points.drop();
    expect(moves).toEqual([]);
  });
});
