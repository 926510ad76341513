import { afterEach, describe, expect, it, vi } from "vitest";
import { ApiError, call, describeFailure } from "../src/api/client";

afterEach(() => vi.unstubAllGlobals());

function answer(status: number, body?: unknown) {
  const fetch = vi.fn<typeof globalThis.fetch>(() =>
    Promise.resolve(new Response(body === undefined ? null : JSON.stringify(body), { status })),
  );
  vi.stubGlobal("fetch", fetch);
  return fetch;
}

describe("calling the API", () => {
  it("fills in the path, sends the body and the header that foreign pages cannot send", async () => {
    const fetch = answer(200, { id: "a" });
    const body = { id: "a", area: "camp", x: 1, y: 2, radius_m: 0.15, yaw: null };
    await call("put", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: "a/b" }, body });
    const [address, options] = fetch.mock.calls[0] ?? [];
    expect(address).toBe("/api/waypoints/a%2Fb");
    expect(options).toMatchObject({ method: "PUT", body: JSON.stringify(body), headers: { "X-Lilliput": "1" } });
  });

  it("sends a query", async () => {
    const fetch = answer(200, []);
    await call("get", "/api/events", { query: { count: 7 } });
    expect(fetch.mock.calls[0]?.[0]).toBe("/api/events?count=7");
  });

  it("answers undefined where there is no body", async () => {
    answer(204);
    expect(await call("delete", "/api/session")).toBeUndefined();
  });

  it("throws the API's sentence", async () => {
    answer(409, { detail: "waypoint a is used by route round" });
    const failing = call("delete", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: "a" } });
    await expect(failing).rejects.toMatchObject({ status: 409, message: "waypoint a is used by route round" });
  });

  it("says so when nobody answers", async () => {
    vi.stubGlobal("fetch", () => Promise.reject(new TypeError("failed")));
    await expect(call("get", "/api/lab")).rejects.toMatchObject({ status: 0 });
  });
});

describe("describing a failure", () => {
  it("names the refused fields", () => {
    const error = describeFailure(422, { detail: [{ loc: ["body", "x"], msg: "Input should be a finite number" }] });
    expect(error).toBeInstanceOf(ApiError);
    expect(error.message).toBe("x: Input should be a finite number");
    expect(error.fields).toEqual({ x: "Input should be a finite number" });
  });

  it("copes with anything else", () => {
    for (const body of [undefined, null, "x", {}, { detail: "" }, { detail: 3 }])
      expect(describeFailure(502, body).message).toBe("The server answered 502.");
  });
});
