/** The floor, live: the map, the robots beside it, and what is missing. */
import { Alert, Box, Text } from "@mantine/core";
import { IconAlertTriangle } from "@tabler/icons-react";
import { useCallback, useRef } from "react";
import { RobotList } from "../fleet/RobotList";
import { RobotPanel } from "../fleet/RobotPanel";
import { useLive } from "../live/store";
import { formatStamp, withSince } from "../ui/format";
import { usePageTitle } from "../ui/Page";
import classes from "./floor.module.css";
import { selectRobot, useFloor } from "./floor-state";
import type { FloorMap } from "./FloorMap";
import { MapToolbar } from "./MapToolbar";
import { MapView } from "./MapView";
import { SpeedLimits } from "./SpeedLimits";

export default function FloorPage() {
  const mapRef = useRef<FloorMap | null>(null);
  const selected = useFloor((floor) => floor.robot);
  const robot = useLive((live) => (selected === null ? undefined : live.state.robots[selected]));
  usePageTitle("Floor");

  const onSelect = useCallback((id: string) => {
    selectRobot(id);
    mapRef.current?.centreOn(id, false);
  }, []);
  return (
    <div className={classes["page"]}>
      <div className={classes["stage"]}>
        <MapView mapRef={mapRef} />
        <MapToolbar mapRef={mapRef} />
        <SpeedLimits />
        <Missing />
      </div>
      <Box component="aside" className={classes["panel"] ?? ""} aria-label="Robots and the selected one">
        <RobotList selected={selected} onSelect={onSelect} />
        {robot ? (
          <RobotPanel robot={robot} />
        ) : (
          <Text p="md" size="sm" c="dimmed">
            Select a robot, here or on the map, to start a route or to drive it by hand.
          </Text>
        )}
      </Box>
    </div>
  );
}

/** Why the map may be empty or old: a lost connection, or the first thing that robots need and that is missing. */
function Missing() {
  const connection = useLive((live) => live.connection);
  const health = useLive((live) => live.state.health);
  const errors = health?.problems.filter(({ severity }) => severity === "error") ?? [];
  const text =
    connection.state === "reconnecting"
      ? `No connection to the server since ${formatStamp(connection.sinceMs * 1e6)}; this is the last known state.`
      : errors[0] && withSince(errors[0]);
  if (!text) return null;
  return (
    <Alert
      className={classes["notice"] ?? ""}
      color="red"
      p="xs"
      icon={<IconAlertTriangle />}
      data-testid="floor-missing"
    >
      <Text size="sm">
        {text}
        {connection.state !== "reconnecting" && errors.length > 1 && ` (and ${errors.length - 1} more)`}
      </Text>
    </Alert>
  );
}
