/**
 * The server's time as seen from here, so that an age is right on a tablet whose clock is wrong. The message that travelled
 * fastest tells the offset best; the estimate forgets slowly so that a drifting clock is followed.
 */
const FORGET_MS_PER_S = 1;

export class ServerClock {
  private offsetMs: number | null = null;
  private heardMs = 0;

  /** A message stamped `stampNs` by the server arrived at `nowMs` of the local clock. */
  hear(stampNs: number, nowMs: number): void {
    const offset = stampNs / 1e6 - nowMs;
    const kept = this.offsetMs === null ? offset : this.offsetMs - (FORGET_MS_PER_S * (nowMs - this.heardMs)) / 1000;
    this.offsetMs = Math.max(offset, kept);
    this.heardMs = nowMs;
  }

  /** Milliseconds since the epoch on the server's clock. */
  now(nowMs: number): number {
    return nowMs + (this.offsetMs ?? 0);
  }
}
