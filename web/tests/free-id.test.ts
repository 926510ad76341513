import { describe, expect, it } from "vitest";
import { ApiError } from "../src/api/client";
import { createWithFreeId } from "../src/floor/edits";

describe("creating under a free id", () => {
  it("takes the first number that nobody has", async () => {
    expect(await createWithFreeId("wp", { "wp-1": {}, "wp-3": {} }, () => Promise.resolve())).toBe("wp-2");
  });

  it("goes on to the next when the server says that it is taken already", async () => {
    const server = new Set(["wp-1", "wp-2"]);
    const create = (id: string) =>
      server.has(id) ? Promise.reject(new ApiError(409, `waypoint '${id}' exists already`)) : Promise.resolve();
    expect(await createWithFreeId("wp", {}, create)).toBe("wp-3");
  });

  it("gives up on any other refusal", async () => {
    const refused = new ApiError(422, "outside every area");
    await expect(createWithFreeId("wp", {}, () => Promise.reject(refused))).rejects.toBe(refused);
  });
});
