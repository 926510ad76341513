/** The state of the calibration, fetched again and again while the page is open, more often while something goes on. */
import { useCallback, useEffect, useState } from "react";
import { call } from "../api/client";
import type { CalibrationView } from "../api/types";
import { stageOf } from "./stage";

const PERIOD_MS = 1500;
const BUSY_PERIOD_MS = 300;

export interface Calibrating {
  readonly view: CalibrationView | null;
  /** Why the newest fetch failed; the view is the last one that came. */
  readonly problem: string | null;
  readonly refresh: () => Promise<void>;
}

export function useCalibration(): Calibrating {
  const [view, setView] = useState<CalibrationView | null>(null);
  const [problem, setProblem] = useState<string | null>(null);
  const refresh = useCallback(async () => {
    try {
      setView(await call("get", "/api/calibration"));
      setProblem(null);
    } catch (error) {
      setProblem(error instanceof Error ? error.message : String(error));
    }
  }, []);
  const period = view && stageOf(view) === "collect" ? BUSY_PERIOD_MS : PERIOD_MS;
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isEnded = false;
    const tick = async () => {
      if (!document.hidden) await refresh();
      if (!isEnded) timer = setTimeout(() => void tick(), period);
    };
    void tick();
    return () => {
      isEnded = true;
      clearTimeout(timer);
    };
  }, [refresh, period]);
  return { view, problem, refresh };
}
