/** A list of the API that is fetched now and again after each change. */
import { useCallback, useEffect, useState } from "react";
import { showError } from "../api/action";

export function useList<T>(
  what: string,
  fetchList: () => Promise<T[]>,
): [list: readonly T[] | null, refresh: () => void] {
  const [list, setList] = useState<readonly T[] | null>(null);
  const refresh = useCallback(() => {
    fetchList().then(setList, (error: unknown) => showError(`Fetching the ${what}`, error));
  }, [what, fetchList]);
  useEffect(refresh, [refresh]);
  return [list, refresh];
}
