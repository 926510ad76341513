/** The floor, live: the map, the robots beside it, and what is missing. */
import { Alert, Box, Text } from "@mantine/core";
import { IconAlertTriangle } from "@tabler/icons-react";
import { useCallback, useRef } from "react";
import { RobotList } from "../fleet/RobotList";
import { RobotPanel } from "../fleet/RobotPanel";
import { useLive } from "../live/store";
import { formatStamp } from "../ui/format";
import { usePageTitle } from "../ui/Page";
import classes from "./floor.module.css";
import { selectRobot, useFloor } from "./floor-state";
import type { FloorMap } from "./FloorMap";
import { MapToolbar } from "./MapToolbar";
import { MapView } from "./MapView";

export default function FloorPage() {
  const mapRef = useRef<FloorMap | null>(null);
  const selected = useFloor((floor) => floor.robot);
  const robot = useLive((live) => (selected === null ? undefined : live.state.robots[selected]));
  usePageTitle("Floor");

  const onSelect = useCallback((id: string) => {
    selectRobot(id);
    mapRef.current?.centreOn(id);
  }, []);
  return (
    <div className={classes["page"]}>
      <div className={classes["stage"]}>
        <MapView mapRef={mapRef} />
        <MapToolbar mapRef={mapRef} />
        <Missing />
      </div>
      <Box component="aside" className={classes["panel"] ?? ""} aria-label="Robots and the selected one">
        <RobotList selected={selected} onSelect={onSelect} />
        {robot && <RobotPanel robot={robot} />}
      </Box>
    </div>
  );
}

/** Why the map may be empty or old: the first thing that robots need and that is missing. */
function Missing() {
  const problem = useLive((live) => live.state.health?.problems.find(({ severity }) => severity === "error"));
  if (!problem) return null;
  return (
    <Alert
      className={classes["notice"] ?? ""}
      color="red"
      p="xs"
      icon={<IconAlertTriangle />}
      data-testid="floor-missing"
    >
      <Text size="sm">
        {problem.text}
        {problem.since_ns !== null && !problem.text.includes("since") && ` (since ${formatStamp(problem.since_ns)})`}
      </Text>
    </Alert>
  );
}
