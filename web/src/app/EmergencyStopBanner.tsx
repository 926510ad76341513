/** While the emergency stop is engaged: who, when and why, on every page, and the way to release it. */
import { Button, Group, Modal, Stack, Text } from "@mantine/core";
import { IconAlertOctagonFilled } from "@tabler/icons-react";
import { useState } from "react";
import type { EmergencyStop } from "../api/types";
import { useLive } from "../live/store";
import { formatStamp } from "../ui/format";
import { Guarded } from "../ui/Guarded";
import { release } from "./emergency-stop";
import classes from "./shell.module.css";

export const BANNER_HEIGHT = 48;

export function EmergencyStopBanner({ estop }: { readonly estop: EmergencyStop }) {
  const [asking, setAsking] = useState(false);
  const [busy, setBusy] = useState(false);
  const moving = useLive(
    (live) => Object.values(live.state.robots).filter((robot) => robot.assignment?.state === "running").length,
  );

  const confirm = async () => {
    setBusy(true);
    if (await release()) setAsking(false);
    setBusy(false);
  };
  return (
    <div className={classes["banner"]} role="alert" data-testid="estop-banner" style={{ height: BANNER_HEIGHT }}>
      <IconAlertOctagonFilled size={22} />
      <Text fw={700}>Emergency stop</Text>
      <Text size="sm" truncate flex={1}>
        engaged{estop.by && ` by ${estop.by}`} at {formatStamp(estop.stamp_ns)}
        {estop.reason && ` · ${estop.reason}`}
      </Text>
      <Guarded>
        <Button variant="white" color="red.9" size="xs" data-testid="estop-release" onClick={() => setAsking(true)}>
          Release…
        </Button>
      </Guarded>
      <Modal opened={asking} onClose={() => setAsking(false)} title="Release the emergency stop?" centered>
        <Stack>
          <Text size="sm">
            Robots may move again at once.{" "}
            {moving > 0 &&
              `${moving === 1 ? "One robot has" : `${moving} robots have`} a running route and will drive on. `}
            Make sure that nobody is on the floor.
          </Text>
          <Group justify="flex-end">
            <Button variant="default" onClick={() => setAsking(false)} data-autofocus>
              Keep stopped
            </Button>
            <Button color="red" loading={busy} data-testid="estop-release-confirm" onClick={() => void confirm()}>
              Release
            </Button>
          </Group>
        </Stack>
      </Modal>
    </div>
  );
}
