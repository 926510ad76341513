/** What a click on a button does: call the API, and say so when it failed. */
import { notifications } from "@mantine/notifications";
import { ApiError } from "./client";

/** Shows an error in the API's own words. The same text twice is shown once. */
export function showError(doing: string, error: unknown): void {
  const message = error instanceof ApiError ? error.message : String(error);
  notifications.show({
    id: `${doing}: ${message}`,
    title: `${doing} failed`,
    message,
    color: "red",
    autoClose: 8000,
    "data-testid": "toast-error",
  });
}

export function showDone(message: string): void {
  notifications.show({ message, color: "teal", autoClose: 3000, "data-testid": "toast-done" });
}

/** Runs a request; true when it worked, a toast when it did not. `doing` reads like "Starting route a". */
export async function act(doing: string, request: () => Promise<unknown>): Promise<boolean> {
  try {
    await request();
    return true;
  } catch (error) {
    showError(doing, error);
    return false;
  }
}
