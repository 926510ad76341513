/** The lab description, fetched once after the log-in and again until it comes. */
import { create } from "zustand";
import { call } from "../api/client";
import type { LabView } from "../api/types";

const useLabStore = create<{ readonly lab: LabView | null }>(() => ({ lab: null }));
const RETRY_MS = 2000;

export function useLab(): LabView | null {
  return useLabStore((store) => store.lab);
}

/** Starts fetching; returns what ends it. */
export function startFetchingLab(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let ended = false;
  const fetchLab = async () => {
    try {
      const lab = await call("get", "/api/lab");
      if (!ended) useLabStore.setState({ lab });
    } catch {
      if (!ended) timer = setTimeout(() => void fetchLab(), RETRY_MS);
    }
  };
  void fetchLab();
  return () => {
    ended = true;
    clearTimeout(timer);
  };
}
