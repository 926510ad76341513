/** Numbers as people read them. */

/** "40 ms", "1.2 s", "3 min 20 s", "2 h 5 min", "4 days". */
export function formatDuration(ms: number): string {
  if (ms < 1000) return `${Math.max(0, Math.round(ms))} ms`;
  if (ms < 10_000) return `${(ms / 1000).toFixed(1)} s`;
  const seconds = Math.floor(ms / 1000);
  if (seconds < 60) return `${seconds} s`;
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return `${minutes} min ${seconds % 60} s`;
  const hours = Math.floor(minutes / 60);
  if (hours < 48) return `${hours} h ${minutes % 60} min`;
  return `${Math.floor(hours / 24)} days`;
}

/** The time of day of a stamp in nanoseconds, with the date when that is not today. */
export function formatStamp(stampNs: number, nowMs: number = Date.now()): string {
  const date = new Date(stampNs / 1e6);
  const time = date.toLocaleTimeString("en-GB");
  const isToday = date.toDateString() === new Date(nowMs).toDateString();
  return isToday ? time : `${date.toLocaleDateString("en-CA")} ${time}`;
}

/** A problem's sentence, with the time since when unless the sentence has one. */
export function withSince({ text, since_ns }: { readonly text: string; readonly since_ns: number | null }): string {
  return since_ns === null || text.includes("since") ? text : `${text} (since ${formatStamp(since_ns)})`;
}

/** "0.2 m/s", "1 m/s", "0.35 m/s". */
export function formatSpeed(metresPerSecond: number): string {
  return `${Number(metresPerSecond.toFixed(2))} m/s`;
}

export function degrees(radians: number): number {
  return (radians * 180) / Math.PI;
}

export function radians(degreesValue: number): number {
  return (degreesValue * Math.PI) / 180;
}
