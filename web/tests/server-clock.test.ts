import { expect, it } from "vitest";
import { ServerClock } from "../src/live/server-clock";

it("tells the server's time although the local clock is wrong", () => {
  const clock = new ServerClock();
  clock.hear(1_000_000 * 1e6, 400_000);
  expect(clock.now(400_050)).toBe(1_000_050);
});

it("believes the message that travelled fastest", () => {
  const clock = new ServerClock();
  clock.hear(1_000_000 * 1e6, 400_080);
  clock.hear(1_000_050 * 1e6, 400_060);
  clock.hear(1_000_100 * 1e6, 400_400);
  expect(clock.now(400_400)).toBeCloseTo(1_000_390, 0);
});

it("follows a clock that drifts back", () => {
  const clock = new ServerClock();
  clock.hear(0, 0);
  for (let second = 1; second <= 100; second += 1) clock.hear((second * 1000 - 50) * 1e6, second * 1000);
  expect(clock.now(100_000)).toBeCloseTo(99_950, 0);
});
