// @vitest-environment jsdom
import { MantineProvider } from "@mantine/core";
import { act, cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { LiveSnapshot, Role } from "../src/api/types";
import { EmergencyStopBanner } from "../src/app/EmergencyStopBanner";
import { EmergencyStopButton } from "../src/app/EmergencyStopButton";
import { useSession } from "../src/app/session";
import { Stick } from "../src/fleet/Stick";
import { forget, takeMessage } from "../src/live/store";

const fetch = vi.fn<typeof globalThis.fetch>(() => Promise.resolve(new Response("{}")));
const engaged = { engaged: true, epoch: 1, stamp_ns: Date.now() * 1e6, by: "olga", reason: "person on the floor" };

function logIn(role: Role) {
  useSession.setState({ state: "in", user: "olga", role }, true);
}

function show(element: React.ReactNode) {
  return render(<MantineProvider>{element}</MantineProvider>);
}

const sent = () => fetch.mock.calls.map(([address, options]) => [options?.method, address, options?.body]);

beforeEach(() => {
  vi.stubGlobal("fetch", fetch);
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener: vi.fn(), removeEventListener: vi.fn() }));
  vi.stubGlobal(
    "ResizeObserver",
    class {
      observe = vi.fn();
      unobserve = vi.fn();
      disconnect = vi.fn();
    },
  );
  logIn("operator");
});
afterEach(() => {
  cleanup();
  fetch.mockClear();
  forget();
  vi.unstubAllGlobals();
});

describe("the emergency stop", () => {
  it("engages when it is pressed, not when it is let go, and once", async () => {
    show(<EmergencyStopButton />);
    const button = screen.getByTestId("estop-engage");
    const engaged = ["POST", "/api/estop", '{"reason":"red button in the console"}'];
    await act(async () => {
      fireEvent.pointerDown(button, { button: 0 });
      await Promise.resolve();
    });
    expect(sent()).toEqual([engaged]);
    await act(async () => {
      fireEvent.pointerUp(button, { button: 0 });
      fireEvent.click(button, { detail: 1 });
      await Promise.resolve();
    });
    expect(sent()).toEqual([engaged]);
  });

  it("engages with the keyboard", async () => {
    show(<EmergencyStopButton />);
    await act(async () => {
      fireEvent.click(screen.getByTestId("estop-engage"), { detail: 0 });
      await Promise.resolve();
    });
    expect(sent()).toEqual([["POST", "/api/estop", '{"reason":"red button in the console"}']]);
  });

  it("engages with Shift + Space, also while somebody types, once per press", async () => {
    show(
      <>
        <EmergencyStopButton />
        <input aria-label="text" />
      </>,
    );
    const key = { code: "Space", shiftKey: true };
    await act(async () => {
      fireEvent.keyDown(screen.getByLabelText("text"), key);
      fireEvent.keyDown(screen.getByLabelText("text"), { ...key, repeat: true });
      fireEvent.keyDown(screen.getByLabelText("text"), { code: "Space" });
      await Promise.resolve();
    });
    expect(sent()).toEqual([["POST", "/api/estop", '{"reason":"Shift + Space in the console"}']]);
  });

  it("is not for viewers", () => {
    logIn("viewer");
    show(<EmergencyStopButton />);
    expect(screen.getByTestId<HTMLButtonElement>("estop-engage").disabled).toBe(true);
    fireEvent.keyDown(document.body, { code: "Space", shiftKey: true });
    expect(sent()).toEqual([]);
  });

  it("says at once that it is engaged", () => {
    show(<EmergencyStopButton />);
    act(() => {
      takeMessage({ type: "snapshot", stamp_ns: 1, estop: engaged } as unknown as LiveSnapshot);
    });
    expect(screen.getByTestId("estop-engage").dataset["engaged"]).toBe("true");
  });

  it("is released only after a second thought", async () => {
    show(<EmergencyStopBanner estop={engaged} />);
    expect(screen.getByTestId("estop-banner").textContent).toContain("by olga");
    expect(screen.getByTestId("estop-banner").textContent).toContain("person on the floor");
    fireEvent.click(screen.getByTestId("estop-release"));
    expect(sent()).toEqual([]);
    fireEvent.click(await screen.findByTestId("estop-release-confirm"));
    expect(sent()).toEqual([["DELETE", "/api/estop", '{"confirm":true}']]);
  });
});

describe("the stick", () => {
  it("is driven by keys and springs back when they are let go or the focus goes", () => {
    const onDeflect = vi.fn();
    show(<Stick label="stick" disabled={false} onDeflect={onDeflect} />);
    const stick = screen.getByTestId("stick");
    fireEvent.keyDown(stick, { code: "KeyW" });
    fireEvent.keyDown(stick, { code: "ArrowLeft" });
    expect(onDeflect).toHaveBeenLastCalledWith({ forward: 1, left: 1 });
    fireEvent.keyUp(stick, { code: "ArrowLeft" });
    expect(onDeflect).toHaveBeenLastCalledWith({ forward: 1, left: 0 });
    fireEvent.keyUp(stick, { code: "KeyW" });
    expect(onDeflect).toHaveBeenLastCalledWith(null);
    fireEvent.keyDown(stick, { code: "KeyS" });
    fireEvent.blur(stick);
    expect(onDeflect).toHaveBeenLastCalledWith(null);
  });

  it("springs back when the window loses the focus", () => {
    const onDeflect = vi.fn();
    show(<Stick label="stick" disabled={false} onDeflect={onDeflect} />);
    fireEvent.keyDown(screen.getByTestId("stick"), { code: "KeyW" });
    fireEvent.blur(window);
    expect(onDeflect).toHaveBeenLastCalledWith(null);
    expect(screen.getByTestId("stick").dataset["held"]).toBe("false");
  });

  it("does nothing while it is disabled", () => {
    const onDeflect = vi.fn();
    show(<Stick label="stick" disabled onDeflect={onDeflect} />);
    fireEvent.keyDown(screen.getByTestId("stick"), { code: "KeyW" });
    expect(onDeflect).not.toHaveBeenCalled();
  });
});
