/** Starts the live stream of a logged-in console and feeds the store; returns what ends it. */
import { refreshSession } from "../app/session";
import type { LiveMessage } from "../api/types";
import { forget, startSampling, takeConnection, takeMessage } from "./store";
import { LiveStream } from "./stream";

export function startLive(): () => void {
  const stream = new LiveStream({
    open: () => new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/live`),
    onMessage: (message) => takeMessage(message as LiveMessage),
    onConnection: takeConnection,
    onFailure: () => void refreshSession(),
  });
  const endSampling = startSampling();
  stream.start();
  return () => {
    stream.stop();
    endSampling();
    forget();
  };
}
