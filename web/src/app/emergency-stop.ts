/** Engaging and releasing the fleet-wide emergency stop. Engaging is always one step, releasing asks first. */
import { useEffect } from "react";
import { act } from "../api/action";
import { call } from "../api/client";

export const SHORTCUT = "Shift + Space";

export function engage(reason: string): Promise<boolean> {
  return act("The emergency stop", () => call("post", "/api/estop", { body: { reason } }));
}

export function release(): Promise<boolean> {
  return act("Releasing the emergency stop", () => call("delete", "/api/estop", { body: { confirm: true } }));
}

/** Stops the fleet on Shift + Space, wherever the focus is: stopping is always the safe direction. */
export function useEmergencyStopKey(enabled: boolean): void {
  useEffect(() => {
    if (!enabled) return;
    const onKey = (event: KeyboardEvent) => {
      if (event.code !== "Space" || !event.shiftKey) return;
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) void engage(`${SHORTCUT} in the console`);
    };
    window.addEventListener("keydown", onKey, { capture: true });
    return () => window.removeEventListener("keydown", onKey, { capture: true });
  }, [enabled]);
}
