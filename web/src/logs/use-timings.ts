/** The runs and the timings of those chosen, fetched anew while the page is open and in sight. */
import { useEffect, useRef, useState } from "react";
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
            setState((known) => ({ key, value: known.value, error: text }));
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

/**
 * The timings of these runs in this order; `lastS` null for the whole runs. Runs that are gone are left out, and one that was
 * not written to since is not fetched again: a whole run may be a hundred megabytes to the server.
 */
export function useTimings(runs: readonly TimingRunView[], lastS: number | null): Fetched<readonly RunTimingsView[]> {
  const kept = useRef(new Map<string, RunTimingsView>());
  const wanted = runs.map((run) => ({ name: run.name, key: JSON.stringify([run.name, run.newest_ns, lastS]) }));
  return useRefreshed(wanted.map(({ key }) => key).join(), async () => {
    const fetched = await Promise.all(
      wanted.map(async ({ name, key }) => [key, kept.current.get(key) ?? (await fetchTimings(name, lastS))] as const),
    );
    const found = fetched.filter((entry): entry is readonly [string, RunTimingsView] => entry[1] !== null);
    kept.current = new Map(found);
    return found.map(([, timings]) => timings);
  });
}

async function fetchTimings(run: string, lastS: number | null): Promise<RunTimingsView | null> {
  try {
    return await call("get", "/api/timings/{run}", { path: { run }, query: lastS === null ? {} : { last_s: lastS } });
  } catch (error) {
    if (error instanceof ApiError && error.status === 404) return null;
    throw error;
  }
}
