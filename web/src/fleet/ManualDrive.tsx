/** Driving by hand: a stick for mouse and touch, keys while the stick has the focus. */
import { Alert, Group, Kbd, Slider, Stack, Text } from "@mantine/core";
import { useCallback, useEffect, useMemo, useRef, useState } from "react";
import { showError } from "../api/action";
import { ApiError, call } from "../api/client";
import type { RobotView } from "../api/types";
import { useMay } from "../app/session";
import { useLive } from "../live/store";
import { ManualLink } from "./manual-link";
import { Stick, type Deflection } from "./Stick";

export function ManualDrive({ robot }: { readonly robot: RobotView }) {
  const may = useMay("operator");
  const isStopped = useLive((live) => live.state.estop?.engaged ?? false);
  const [percent, setPercent] = useState(50);
  const [refusal, setRefusal] = useState<string | null>(null);
  const [ownHolder, setOwnHolder] = useState<string | null>(null);
  const { id } = robot;
  const link = useMemo(
    () =>
      new ManualLink({
        drive: async (twist) => {
          const applied = await call("put", "/api/robots/{robot_id}/manual", { path: { robot_id: id }, body: twist });
          setOwnHolder(applied.holder);
          setRefusal(null);
        },
        letGo: () => call("delete", "/api/robots/{robot_id}/manual", { path: { robot_id: id } }),
        onRefused: (error) => {
          setRefusal(error instanceof ApiError ? error.message : String(error));
          if (!(error instanceof ApiError && error.status === 409)) showError(`Driving ${id}`, error);
        },
      }),
    [id],
  );
  const isEnabled = may && !isStopped;
  useEffect(() => {
    if (!isEnabled) link.release();
    return () => link.release();
  }, [link, isEnabled]);

  const limits = useRef(robot.limits);
  useEffect(() => {
    limits.current = robot.limits;
  }, [robot.limits]);
  const onDeflect = useCallback(
    (deflection: Deflection | null) => {
      if (deflection === null) {
        link.release();
        return;
      }
      const share = percent / 100;
      link.hold({
        linear_mps: deflection.forward * share * limits.current.speed_mps,
        angular_radps: deflection.left * share * limits.current.yaw_rate_radps,
      });
    },
    [link, percent],
  );
  const { manual } = robot;
  return (
    <Stack gap="xs">
      <Group wrap="nowrap" align="center" gap="md">
        <Stick key={String(isEnabled)} disabled={!isEnabled} label={`Stick of ${id}`} onDeflect={onDeflect} />
        <Stack gap="xs" flex={1}>
          <Text size="sm" fw={500}>
            Full stick {(robot.limits.speed_mps * (percent / 100)).toFixed(2)} m/s
          </Text>
          <Slider min={10} max={100} step={10} value={percent} label={null} aria-label="Speed" onChange={setPercent} />
          <Text size="xs" c="dimmed">
            Drag the stick, or click it and use <Kbd size="xs">W</Kbd> <Kbd size="xs">A</Kbd> <Kbd size="xs">S</Kbd>{" "}
            <Kbd size="xs">D</Kbd> or the arrow keys. Letting go hands the robot back.
          </Text>
        </Stack>
      </Group>
      {manual && (
        <Text size="sm" c="grape" data-testid="manual-holder">
          {manual.holder === ownHolder ? "You hold the stick" : `Driven by ${manual.by}`}
        </Text>
      )}
      {!may && (
        <Text size="xs" c="dimmed">
          Your role may only look.
        </Text>
      )}
      {isStopped && (
        <Text size="xs" c="dimmed">
          Not while the emergency stop is engaged.
        </Text>
      )}
      {refusal !== null && (
        <Alert color="red" p="xs" data-testid="manual-refused">
          {refusal}
        </Alert>
      )}
    </Stack>
  );
}
