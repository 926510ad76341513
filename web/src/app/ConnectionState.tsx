/** Whether what the console shows is live, and since when it is not. */
import { Badge, Tooltip } from "@mantine/core";
import { useLive } from "../live/store";
import { formatDuration } from "../ui/format";
import classes from "./shell.module.css";

export function ConnectionState() {
  const connection = useLive((live) => live.connection);
  const lostMs = useLive((live) =>
    live.connection.state === "live" ? 0 : Math.max(0, live.sampledMs - connection.sinceMs),
  );
  if (connection.state === "live") {
    return (
      <Tooltip label="The console receives what happens 20 times a second.">
        <Badge
          variant="dot"
          color="teal"
          tt="none"
          className={classes["wide"] ?? ""}
          data-testid="connection"
          data-state="live"
        >
          Live
        </Badge>
      </Tooltip>
    );
  }
  return (
    <Tooltip label="What you see is the last known state. The console reconnects by itself.">
      <Badge variant="filled" color="orange.8" tt="none" data-testid="connection" data-state={connection.state}>
        {connection.state === "connecting"
          ? "Connecting…"
          : `Reconnecting, lost ${formatDuration(Math.floor(lostMs / 1000) * 1000)} ago`}
      </Badge>
    </Tooltip>
  );
}
