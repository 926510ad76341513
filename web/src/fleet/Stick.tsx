/** A stick on the screen. It springs back when it is let go, hidden, or loses the focus while driven by keys. */
import { useEffect, useEffectEvent, useRef, useState, type KeyboardEvent, type PointerEvent } from "react";
import classes from "./stick.module.css";

/** How far the stick is pushed, -1 to 1. */
export interface Deflection {
  readonly forward: number;
  readonly left: number;
}

interface StickProps {
  readonly label: string;
  readonly disabled: boolean;
  /** null: let go. */
  readonly onDeflect: (deflection: Deflection | null) => void;
}

const KEYS: Readonly<Record<string, Deflection>> = {
  KeyW: { forward: 1, left: 0 },
  ArrowUp: { forward: 1, left: 0 },
  KeyS: { forward: -1, left: 0 },
  ArrowDown: { forward: -1, left: 0 },
  KeyA: { forward: 0, left: 1 },
  ArrowLeft: { forward: 0, left: 1 },
  KeyD: { forward: 0, left: -1 },
  ArrowRight: { forward: 0, left: -1 },
};
const DEAD_ZONE = 0.08;

/** Where the stick is for a pointer at (x, y) from its centre, in shares of its radius, y down. */
export function deflectionAt(x: number, y: number): Deflection {
  const reach = Math.hypot(x, y);
  if (reach < DEAD_ZONE) return { forward: 0, left: 0 };
  const kept = Math.min(1, reach) / reach;
  return { forward: -y * kept, left: -x * kept };
}

export function Stick({ label, disabled, onDeflect }: StickProps) {
  const base = useRef<HTMLDivElement>(null);
  const pressed = useRef(new Set<string>());
  const [held, setHeld] = useState<Deflection | null>(null);

  const move = (deflection: Deflection) => {
    setHeld(deflection);
    onDeflect(deflection);
  };
  const letGo = useEffectEvent(() => {
    pressed.current.clear();
    if (held === null) return;
    setHeld(null);
    onDeflect(null);
  });
  const release = () => {
    pressed.current.clear();
    setHeld(null);
    onDeflect(null);
  };
  useEffect(() => {
    const onHidden = () => letGo();
    window.addEventListener("blur", onHidden);
    document.addEventListener("visibilitychange", onHidden);
    return () => {
      window.removeEventListener("blur", onHidden);
      document.removeEventListener("visibilitychange", onHidden);
    };
  }, []);

  const follow = (event: PointerEvent) => {
    const box = base.current?.getBoundingClientRect();
    if (!box) return;
    const radius = box.width / 2;
    move(deflectionAt((event.clientX - box.left) / radius - 1, (event.clientY - box.top) / radius - 1));
  };
  const onPointerDown = (event: PointerEvent) => {
    if (disabled || event.button !== 0) return;
    base.current?.setPointerCapture(event.pointerId);
    follow(event);
  };
  const onPointerMove = (event: PointerEvent) => {
    if (base.current?.hasPointerCapture(event.pointerId)) follow(event);
  };
  const steer = (code: string, isDown: boolean) => {
    if (isDown) pressed.current.add(code);
    else pressed.current.delete(code);
    const keys = [...pressed.current].flatMap((key) => KEYS[key] ?? []);
    if (keys.length === 0) {
      release();
      return;
    }
    const sum = (part: keyof Deflection) =>
      Math.max(
        -1,
        Math.min(
          1,
          keys.reduce((total, key) => total + key[part], 0),
        ),
      );
    move({ forward: sum("forward"), left: sum("left") });
  };
  const onKey = (event: KeyboardEvent, isDown: boolean) => {
    if (disabled || !(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (isDown && event.repeat) return;
    steer(event.code, isDown);
  };
  const knob = held ?? { forward: 0, left: 0 };
  return (
    <div
      ref={base}
      role="application"
      aria-label={label}
      aria-disabled={disabled}
      aria-keyshortcuts="W A S D ArrowUp ArrowLeft ArrowDown ArrowRight"
      tabIndex={disabled ? -1 : 0}
      className={classes["base"]}
      data-testid="stick"
      data-held={held !== null}
      onPointerDown={onPointerDown}
      onPointerMove={onPointerMove}
      onLostPointerCapture={release}
      onKeyDown={(event) => onKey(event, true)}
      onKeyUp={(event) => onKey(event, false)}
      onBlur={release}
    >
      <div
        className={classes["knob"]}
        style={{ transform: `translate(${-knob.left * 100}%, ${-knob.forward * 100}%)` }}
      />
    </div>
  );
}
