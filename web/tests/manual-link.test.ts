import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ManualLink, type Twist } from "../src/fleet/manual-link";

const forward: Twist = { linear_mps: 0.2, angular_radps: 0 };

interface Pending {
  readonly what: string;
  readonly answer: () => Promise<void>;
  readonly refuse: (error: Error) => Promise<void>;
}

let sent: Pending[];
let refused: unknown[];
let link: ManualLink;

function request(what: string): Promise<void> {
  return new Promise((resolve, reject) => {
    const settle = async (how: () => void) => {
      how();
      await vi.advanceTimersByTimeAsync(0);
    };
    sent.push({ what, answer: () => settle(resolve), refuse: (error) => settle(() => reject(error)) });
  });
}

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  refused = [];
  link = new ManualLink({
    drive: (twist) => request(`drive ${twist.linear_mps}`),
    letGo: () => request("let go"),
    onRefused: (error) => refused.push(error),
  });
});
afterEach(() => vi.useRealTimers());

describe("the wire of the stick", () => {
  it("renews the lease ten times a second with the newest twist", async () => {
    link.hold(forward);
    await sent[0]?.answer();
    link.hold({ ...forward, linear_mps: 0.3 });
    await vi.advanceTimersByTimeAsync(100);
    expect(sent.map(({ what }) => what)).toEqual(["drive 0.2", "drive 0.3"]);
  });

  it("never has two requests under way", async () => {
    link.hold(forward);
    await vi.advanceTimersByTimeAsync(1000);
    expect(sent).toHaveLength(1);
  });

  it("hands the robot back at once when it is let go", async () => {
    link.hold(forward);
    await sent[0]?.answer();
    link.release();
    expect(sent.map(({ what }) => what)).toEqual(["drive 0.2", "let go"]);
    await sent[1]?.answer();
    await vi.advanceTimersByTimeAsync(1000);
    expect(sent).toHaveLength(2);
  });

  it("hands it back after the request that was under way, so that none overtakes the other", async () => {
    link.hold(forward);
    link.release();
    expect(sent.map(({ what }) => what)).toEqual(["drive 0.2"]);
    await sent[0]?.answer();
    expect(sent.map(({ what }) => what)).toEqual(["drive 0.2", "let go"]);
  });

  it("lets go by itself when somebody else holds the stick", async () => {
    link.hold(forward);
    await sent[0]?.refuse(new Error("bert holds the stick"));
    await vi.advanceTimersByTimeAsync(1000);
    expect(sent).toHaveLength(1);
    expect(refused).toHaveLength(1);
  });

  it("hands nothing back that it never held", () => {
    link.release();
    expect(sent).toEqual([]);
  });
});
