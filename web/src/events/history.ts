/** The history as it is shown: fetched and live events together, newest first. */
import type { Event, EventLevel } from "../api/types";

const RANKS: Readonly<Record<EventLevel, number>> = { info: 0, warning: 1, error: 2 };

function identity({ stamp_ns, source, kind, text }: Event): string {
  return [stamp_ns, source, kind, text].join("\n");
}

/** Both lists, each oldest first, as one: newest first, nothing twice. */
export function combined(older: readonly Event[], live: readonly Event[]): Event[] {
  const byIdentity = new Map([...older, ...live].map((event) => [identity(event), event]));
  return [...byIdentity.values()].sort((a, b) => b.stamp_ns - a.stamp_ns);
}

/** Whether an event is at least of a level and has every word in its text, source or kind. */
export function matches(event: Event, level: EventLevel, words: string): boolean {
  if (RANKS[event.level] < RANKS[level]) return false;
  const text = `${event.source} ${event.kind} ${event.text}`.toLowerCase();
  return words
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
