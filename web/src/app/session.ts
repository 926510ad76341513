/** Who is logged in. The session itself is a cookie that scripts cannot read; the server tells whose it is. */
import { create } from "zustand";
import { ApiError, call } from "../api/client";
import type { Role } from "../api/types";

export type Session =
  | { readonly state: "unknown" }
  | { readonly state: "unreachable" }
  | { readonly state: "out"; readonly ended: boolean }
  | { readonly state: "in"; readonly user: string; readonly role: Role };

export const useSession = create<Session>(() => ({ state: "unknown" }));

const RANKS: Readonly<Record<string, number>> = { viewer: 1, operator: 2, admin: 3 };

/** Whether a role includes another: viewer < operator < admin; robot is apart. */
export function includes(role: Role, needed: Role): boolean {
  return (RANKS[role] ?? 0) >= (RANKS[needed] ?? Infinity);
}

/** Whether the one who is logged in may do what needs `role`. */
export function useMay(role: Role): boolean {
  return useSession((session) => session.state === "in" && includes(session.role, role));
}

/** Asks the server who is logged in. A server that is away does not end a session. */
export async function refreshSession(): Promise<void> {
  const before = useSession.getState();
  try {
    const { user, role } = await call("get", "/api/session");
    useSession.setState({ state: "in", user, role }, true);
  } catch (error) {
    if (error instanceof ApiError && error.status === 401)
      useSession.setState({ state: "out", ended: before.state === "in" }, true);
    else if (before.state !== "in") useSession.setState({ state: "unreachable" }, true);
  }
}

/** Throws ApiError when the server refuses. */
export async function logIn(user: string, password: string): Promise<void> {
  const session = await call("post", "/api/session", { body: { user, password } });
  useSession.setState({ state: "in", user: session.user, role: session.role }, true);
}

export async function logOut(): Promise<void> {
  await call("delete", "/api/session");
  useSession.setState({ state: "out", ended: false }, true);
}
