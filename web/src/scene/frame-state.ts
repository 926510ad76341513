/**
 * How the 3D frame does, as far as its document tells. viser reconnects by itself only while its page has the focus, so a
 * frame beside the focus stays dead after a restart of the scene until it is loaded again.
 */
export type FrameState = "loading" | "alive" | "dead" | "missing";

export function frameState(frame: Document | null): FrameState {
  if (frame?.readyState !== "complete" || frame.URL === "about:blank") return "loading";
  // What answers instead of viser when the scene or the session is away is no page of its own.
  if (!frame.getElementById("root")) return "missing";
  if (frame.querySelector(".tabler-icon-cloud-check")) return "alive";
  const isTrying = frame.querySelector(".tabler-icon-player-pause, .mantine-Loader-root") !== null;
  if (isTrying) return "dead";
  return frame.querySelector("canvas") ? "alive" : "loading";
}
