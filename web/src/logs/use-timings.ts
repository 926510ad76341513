/** The runs and the timings of those chosen, fetched anew while the page is open and in sight. */
import { useEffect, useState } from "react";
import { ApiError, call } from "../api/client";
import type { RunTimingsView, TimingRunView } from "../api/types";

const REFRESH_MS = 3000;

/** `error` is the sentence of the newest failure, null when all is well; what was known stays. */
interface Fetched<T> {
  readonly value: T | null;
  readonly error: string | null;
}

/** Calls `fetch` now and every few seconds, one after the other; a new `key` begins anew. */
function useRefreshed<T>(key: string, fetch: () => Promise<T>): Fetched<T> {
  const [state, setState] = useState<Fetched<T> & { readonly key: string }>({ key, value: null, error: null });
  useEffect(() => {
    let ended = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const refresh = async () => {
      if (document.visibilityState === "visible") {
        try {
          const value = await fetch();
          if (!ended) setState({ key, value, error: null });
        } catch (error) {
          if (!ended) {
            const text = error instanceof ApiError ? error.message : String(error);
            setState((known) => ({ key, value: known.key === key ? known.value : null, error: text }));
          }
        }
      }
      if (!ended) timer = setTimeout(() => void refresh(), REFRESH_MS);
    };
    void refresh();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
    // `fetch` is another function at each render; what it asks for is in `key`.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [key]);
  return state.key === key ? state : { value: state.value, error: null };
}

export function useRuns(): Fetched<readonly TimingRunView[]> {
  return useRefreshed("runs", () => call("get", "/api/timings"));
}

/** The timings of the named runs in this order; `lastS` null for the whole runs. Runs that are gone are left out. */
export function useTimings(names: readonly string[], lastS: number | null): Fetched<readonly RunTimingsView[]> {
  return useRefreshed(JSON.stringify([names, lastS]), async () => {
    const asked = names.map((run) =>
      call("get", "/api/timings/{run}", { path: { run }, query: lastS === null ? {} : { last_s: lastS } }).catch(
        (error: unknown) => {
          if (error instanceof ApiError && error.status === 404) return null;
          throw error;
        },
      ),
    );
    return (await Promise.all(asked)).filter((run) => run !== null);
  });
}
