import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { LiveStream, pauseBefore, type Connection, type Socket } from "../src/live/stream";

class FakeSocket implements Socket {
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  closed = false;

  close() {
    this.closed = true;
  }

  say(data: string) {
    this.onmessage?.({ data } as MessageEvent);
  }

  break() {
    this.onclose?.({} as CloseEvent);
  }
}

let sockets: FakeSocket[];
let messages: unknown[];
let connections: Connection[];
let failures: number;
let stream: LiveStream;
const newest = () => {
  const socket = sockets.at(-1);
  if (!socket) throw new Error("nothing was opened");
  return socket;
};

beforeEach(() => {
  vi.useFakeTimers();
  sockets = [];
  messages = [];
  connections = [];
  failures = 0;
  stream = new LiveStream({
    open: () => {
      sockets.push(new FakeSocket());
      return newest();
    },
    onMessage: (message) => messages.push(message),
    onConnection: (connection) => connections.push(connection),
    onFailure: () => (failures += 1),
    random: () => 0,
  });
  stream.start();
});
afterEach(() => {
  stream.stop();
  vi.useRealTimers();
});

describe("the live stream", () => {
  it("is live with its first message, not before", () => {
    expect(connections.map(({ state }) => state)).toEqual(["connecting"]);
    newest().say('{"type":"snapshot"}');
    newest().say('{"type":"changes"}');
    expect(connections.map(({ state }) => state)).toEqual(["connecting", "live"]);
    expect(messages).toEqual([{ type: "snapshot" }, { type: "changes" }]);
  });

  it("reconnects with growing pauses and says since when it is lost", () => {
    newest().say("{}");
    const lostMs = Date.now();
    newest().break();
    vi.advanceTimersByTime(499);
    expect(sockets).toHaveLength(1);
    vi.advanceTimersByTime(1);
    expect(sockets).toHaveLength(2);
    newest().break();
    vi.advanceTimersByTime(999);
    expect(sockets).toHaveLength(2);
    vi.advanceTimersByTime(1);
    expect(sockets).toHaveLength(3);
    expect(connections.at(-1)).toEqual({ state: "reconnecting", sinceMs: lostMs, attempt: 1 });
    expect(failures).toBe(2);
  });

  it("starts over with short pauses after it was live again", () => {
    newest().break();
    vi.advanceTimersByTime(500);
    newest().break();
    vi.advanceTimersByTime(1000);
    newest().say("{}");
    expect(connections.at(-1)?.state).toBe("live");
    newest().break();
    vi.advanceTimersByTime(500);
    expect(sockets).toHaveLength(4);
  });

  it("gives up on a socket that stays silent", () => {
    newest().say("{}");
    const silent = newest();
    vi.advanceTimersByTime(4999);
    expect(silent.closed).toBe(false);
    vi.advanceTimersByTime(1);
    expect(silent.closed).toBe(true);
    expect(connections.at(-1)?.state).toBe("reconnecting");
  });

  it("drops a connection that talks nonsense", () => {
    newest().say("not json");
    expect(messages).toEqual([]);
    expect(connections.at(-1)?.state).toBe("reconnecting");
  });

  it("stays ended", () => {
    const socket = newest();
    stream.stop();
    expect(socket.closed).toBe(true);
    vi.advanceTimersByTime(60_000);
    expect(sockets).toHaveLength(1);
  });
});

describe("the pause before an attempt", () => {
  it("doubles up to a limit and is spread", () => {
    expect([0, 1, 2, 3, 4, 9].map((attempt) => pauseBefore(attempt, () => 0))).toEqual([
      500, 1000, 2000, 4000, 8000, 8000,
    ]);
    expect(pauseBefore(0, () => 1)).toBeCloseTo(650);
  });
});
