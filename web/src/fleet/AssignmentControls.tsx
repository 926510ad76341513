/** Starts, pauses, resumes and stops a robot's route. */
import { Anchor, Button, Group, Progress, Select, Slider, Stack, Text } from "@mantine/core";
import {
  IconPlayerPause,
  IconPlayerPlay,
  IconPlayerSkipForward,
  IconPlayerStop,
  IconPlayerTrackNext,
} from "@tabler/icons-react";
import { useState } from "react";
import { Link } from "react-router";
import { act } from "../api/action";
import { call } from "../api/client";
import type { RobotView } from "../api/types";
import { useLive } from "../live/store";
import { Guarded } from "../ui/Guarded";
import { describeProgress } from "./progress";
import { isAssigned } from "./robot-state";
import { RouteQueue } from "./RouteQueue";

export function AssignmentControls({ robot }: { readonly robot: RobotView }) {
  return (
    <Stack gap="sm">
      {isAssigned(robot) && <Running robot={robot} />}
      <Start robot={robot} />
      <RouteQueue robot={robot} />
    </Stack>
  );
}

function Running({ robot }: { readonly robot: RobotView }) {
  const { assignment } = robot;
  const route = useLive((live) => (assignment ? live.state.routes[assignment.route] : undefined));
  if (!assignment) return null;
  const path = { robot_id: robot.id };
  const progress = describeProgress(assignment, route);
  const isPaused = assignment.state === "paused";
  const pause = () =>
    act(`Pausing ${robot.id}`, () => call("post", "/api/robots/{robot_id}/assignment/pause", { path }));
  const resume = () =>
    act(`Resuming ${robot.id}`, () => call("post", "/api/robots/{robot_id}/assignment/resume", { path }));
  const skip = () =>
    act(`Skipping a leg of ${robot.id}`, () => call("post", "/api/robots/{robot_id}/assignment/skip", { path }));
  const cancel = () =>
    act(`Cancelling ${robot.id}`, () => call("post", "/api/robots/{robot_id}/assignment/cancel", { path }));
  const proceed = () =>
    act(`Letting ${robot.id} go on`, () => call("post", "/api/robots/{robot_id}/assignment/proceed", { path }));
  const stop = () => act(`Stopping ${robot.id}`, () => call("delete", "/api/robots/{robot_id}/assignment", { path }));
  return (
    <Stack gap="xs">
      <Text size="sm">{progress.text}</Text>
      <Progress value={progress.percent} size="sm" aria-label={progress.text} />
      <Text size="xs" c="dimmed">
        started by {assignment.started_by || "somebody"} at {Math.round(assignment.speed_scale * 100)} % speed
      </Text>
      <Group grow>
        {isPaused ? (
          <Guarded>
            <Button
              fullWidth
              leftSection={<IconPlayerPlay size={16} />}
              data-testid="route-resume"
              onClick={() => void resume()}
            >
              Resume
            </Button>
          </Guarded>
        ) : (
          <Guarded>
            <Button
              fullWidth
              variant="default"
              leftSection={<IconPlayerPause size={16} />}
              data-testid="route-pause"
              onClick={() => void pause()}
            >
              Pause
            </Button>
          </Guarded>
        )}
        <Guarded>
          <Button
            fullWidth
            variant="light"
            color="red"
            leftSection={<IconPlayerStop size={16} />}
            data-testid="route-stop"
            onClick={() => void stop()}
          >
            Stop
          </Button>
        </Guarded>
      </Group>
      <Group grow>
        <Guarded>
          <Button
            fullWidth
            size="xs"
            variant="default"
            leftSection={<IconPlayerSkipForward size={14} />}
            data-testid="route-skip"
            onClick={() => void skip()}
          >
            Skip leg
          </Button>
        </Guarded>
        <Guarded>
          <Button
            fullWidth
            size="xs"
            variant="default"
            leftSection={<IconPlayerTrackNext size={14} />}
            data-testid="route-cancel"
            onClick={() => void cancel()}
          >
            {assignment.queue.length > 0 ? "Next route" : "Cancel"}
          </Button>
        </Guarded>
        {typeof assignment.at_stop_ns === "number" && (
          <Guarded>
            <Button fullWidth size="xs" data-testid="route-proceed" onClick={() => void proceed()}>
              Go on
            </Button>
          </Guarded>
        )}
      </Group>
    </Stack>
  );
}

function Start({ robot }: { readonly robot: RobotView }) {
  const routes = useLive((live) => live.state.routes);
  const [chosen, setChosen] = useState<string | null>(null);
  const [percent, setPercent] = useState(100);
  const ids = Object.keys(routes).sort();
  if (ids.length === 0)
    return (
      <Text size="sm" c="dimmed">
        There is no route yet. Place waypoints on the map, then{" "}
        <Anchor component={Link} to="/routes" inherit>
          build a route
        </Anchor>
        .
      </Text>
    );
  const last = robot.assignment?.route;
  const route =
    chosen !== null && chosen in routes ? chosen : last !== undefined && last in routes ? last : (ids[0] ?? "");
  const isBusy = isAssigned(robot);
  const order = { path: { robot_id: robot.id }, body: { route, speed_scale: percent / 100 } };
  const start = () => act(`Starting ${route}`, () => call("put", "/api/robots/{robot_id}/assignment", order));
  const queue = () => act(`Queueing ${route}`, () => call("post", "/api/robots/{robot_id}/queue", order));
  return (
    <Stack gap="sm">
      {robot.assignment && !isBusy && (
        <Text size="xs" c="dimmed">
          Last: {describeProgress(robot.assignment, routes[robot.assignment.route]).text}
        </Text>
      )}
      <Group align="flex-end" wrap="nowrap">
        <Select
          label="Route"
          flex={1}
          allowDeselect={false}
          data={ids}
          value={route}
          onChange={setChosen}
          data-testid="route-select"
        />
        <Guarded>
          {isBusy ? (
            <Button variant="default" data-testid="route-queue-add" onClick={() => void queue()}>
              Queue
            </Button>
          ) : (
            <Button leftSection={<IconPlayerPlay size={16} />} data-testid="route-start" onClick={() => void start()}>
              Start
            </Button>
          )}
        </Guarded>
      </Group>
      <div>
        <Text size="sm" fw={500}>
          Speed {percent} %
        </Text>
        <Slider min={10} max={150} step={10} value={percent} label={null} aria-label="Speed" onChange={setPercent} />
      </div>
    </Stack>
  );
}
