/** The red button: always visible, one press stops every robot, before the finger is lifted again. */
import { Button, Tooltip } from "@mantine/core";
import { IconHandStop } from "@tabler/icons-react";
import { useState } from "react";
import { useLive } from "../live/store";
import { engage, SHORTCUT, useEmergencyStopKey } from "./emergency-stop";
import classes from "./shell.module.css";
import { useMay } from "./session";

export function EmergencyStopButton() {
  const engaged = useLive((live) => live.state.estop?.engaged ?? false);
  const may = useMay("operator");
  const [busy, setBusy] = useState(false);
  useEmergencyStopKey(may);

  const stop = async () => {
    setBusy(true);
    await engage("red button in the console");
    setBusy(false);
  };
  const hint = may
    ? `Stops every robot at once (${SHORTCUT}). It stays engaged until a person releases it.`
    : "Your role may only look; stopping the fleet needs the role operator.";
  return (
    <Tooltip label={hint}>
      <Button
        className={classes["estop"]}
        classNames={{ label: classes["estopLabel"] ?? "" }}
        data-testid="estop-engage"
        data-engaged={engaged}
        aria-label="Emergency stop"
        aria-keyshortcuts="Shift+Space"
        disabled={!may}
        loading={busy}
        leftSection={<IconHandStop size={20} stroke={2.2} />}
        onPointerDown={(event) => {
          if (event.button === 0) void stop();
        }}
        onClick={(event) => {
          // The keyboard's click alone: a pointer has pressed already.
          if (event.detail === 0) void stop();
        }}
      >
        <span className={classes["wide"]}>{engaged ? "STOPPED" : "EMERGENCY STOP"}</span>
        <span className={classes["narrow"]}>STOP</span>
      </Button>
    </Tooltip>
  );
}
