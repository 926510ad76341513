/**
 * The wire from a stick to a robot: while the stick is held its twist goes to the server ten times a second, which renews
 * the lease; when it is let go the robot is handed back. Never two requests at once, so that none overtakes another.
 */

export interface Twist {
  readonly linear_mps: number;
  readonly angular_radps: number;
}

export interface ManualRequests {
  readonly drive: (twist: Twist) => Promise<unknown>;
  readonly letGo: () => Promise<unknown>;
  /** Driving was refused, or failed: the stick is let go. */
  readonly onRefused: (error: unknown) => void;
}

const PERIOD_MS = 100;

export class ManualLink {
  private twist: Twist | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private isBusy = false;
  private isOurs = false;

  constructor(private readonly requests: ManualRequests) {}

  hold(twist: Twist): void {
    const isNew = this.twist === null;
    this.twist = twist;
    if (!isNew) return;
    this.timer = setInterval(() => void this.send(), PERIOD_MS);
    void this.send();
  }

  release(): void {
    this.twist = null;
    clearInterval(this.timer);
    void this.send();
  }

  private async send(): Promise<void> {
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      if (this.twist) {
        await this.requests.drive(this.twist);
        this.isOurs = true;
      }
      // Let go while the last request was under way, or before it: hand back now.
      if (this.twist === null && this.isOurs) {
        this.isOurs = false;
        await this.requests.letGo();
      }
    } catch (error) {
      this.twist = null;
      clearInterval(this.timer);
      this.requests.onRefused(error);
    } finally {
      this.isBusy = false;
    }
  }
}
