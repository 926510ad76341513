/**
 * The connection to `/api/live`: opens the WebSocket, hands on every message, and reconnects by itself with a growing
 * pause. A socket that stays silent for too long counts as dead even when nobody closed it (a pulled cable closes nothing).
 */

export type Connection =
  | { readonly state: "connecting"; readonly sinceMs: number }
  | { readonly state: "live"; readonly sinceMs: number }
  | { readonly state: "reconnecting"; readonly sinceMs: number; readonly attempt: number };

/** The part of WebSocket that the stream uses. */
export interface Socket {
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  close(): void;
}

export interface StreamOptions {
  readonly open: () => Socket;
  readonly onMessage: (message: unknown) => void;
  readonly onConnection: (connection: Connection) => void;
  /** Called after each failed attempt: the place to find out whether the session has ended. */
  readonly onFailure?: () => void;
  readonly random?: () => number;
}

const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 8000;
const SILENCE_MS = 5000;

/** Pause before an attempt (the first is 0): doubles up to a limit, with up to 30 % more so that clients spread. */
export function pauseBefore(attempt: number, random: () => number): number {
  return Math.min(LONGEST_PAUSE_MS, FIRST_PAUSE_MS * 2 ** attempt) * (1 + 0.3 * random());
}

export class LiveStream {
  private socket: Socket | null = null;
  private pause: ReturnType<typeof setTimeout> | undefined;
  private silence: ReturnType<typeof setTimeout> | undefined;
  private attempt = 0;
  private lostMs: number | null = null;
  private running = false;
  private live = false;

  constructor(private readonly options: StreamOptions) {}

  start(): void {
    this.running = true;
    this.options.onConnection({ state: "connecting", sinceMs: Date.now() });
    this.connect();
  }

  stop(): void {
    this.running = false;
    clearTimeout(this.pause);
    this.drop();
  }

  private connect(): void {
    const socket = this.options.open();
    this.socket = socket;
    this.watchSilence();
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = () => this.lose();
  }

  private receive(data: unknown): void {
    this.watchSilence();
    let message: unknown;
    try {
      message = JSON.parse(String(data));
    } catch {
      this.lose();
      return;
    }
    this.options.onMessage(message);
    if (this.live) return;
    this.live = true;
    this.attempt = 0;
    this.lostMs = null;
    this.options.onConnection({ state: "live", sinceMs: Date.now() });
  }

  private watchSilence(): void {
    clearTimeout(this.silence);
    this.silence = setTimeout(() => this.lose(), SILENCE_MS);
  }

  private lose(): void {
    this.drop();
    if (!this.running) return;
    this.lostMs ??= Date.now();
    this.options.onConnection({ state: "reconnecting", sinceMs: this.lostMs, attempt: this.attempt });
    this.options.onFailure?.();
    this.pause = setTimeout(() => this.connect(), pauseBefore(this.attempt, this.options.random ?? Math.random));
    this.attempt += 1;
  }

  private drop(): void {
    clearTimeout(this.silence);
    this.live = false;
    const socket = this.socket;
    if (!socket) return;
    this.socket = null;
    socket.onmessage = socket.onclose = null;
    socket.close();
  }
}
