/** Builds a route: waypoints in order, a speed for each leg, looped or not; saves, deletes and starts it. */
import { Alert, Button, Group, Select, Stack, Switch, Text, TextInput } from "@mantine/core";
import { IconDeviceFloppy, IconPlus, IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { act, showDone, showError } from "../api/action";
import { ApiError, call } from "../api/client";
import type { Leg, Route } from "../api/types";
import { useLive } from "../live/store";
import { Guarded } from "../ui/Guarded";
import { legOf, plainLeg } from "./leg";
import { LegList, type DraftLeg } from "./LegList";
import classes from "./routes.module.css";
import { StartOnRobot } from "./StartOnRobot";

interface RouteBuilderProps {
  readonly route: Route;
  readonly isNew: boolean;
  readonly onSaved: (route: Route) => void;
  readonly onClose: () => void;
}

const SPEED_MPS = 0.3;

function toDraft(legs: readonly Leg[]): DraftLeg[] {
  return legs.map((leg) => ({ ...leg, key: crypto.randomUUID() }));
}

export function RouteBuilder({ route, isNew, onSaved, onClose }: RouteBuilderProps) {
  const waypoints = useLive((live) => live.state.waypoints);
  const [id, setId] = useState(route.id);
  const [legs, setLegs] = useState(() => toDraft(route.legs));
  const [isLoop, setLoop] = useState(route.loop);
  const [isChanged, setChanged] = useState(isNew);
  const [error, setError] = useState<string | null>(null);
  const ids = Object.keys(waypoints).sort((a, b) => a.localeCompare(b, "en", { numeric: true }));

  const change = (next: DraftLeg[]) => {
    setLegs(next);
    setChanged(true);
  };
  const add = (waypoint: string) => {
    const speed = legs.at(-1)?.speed_mps ?? SPEED_MPS;
    change([...legs, { key: crypto.randomUUID(), ...plainLeg(waypoint, speed) }]);
  };
  const save = async () => {
    const body: Route = { id, legs: legs.map(legOf), loop: isLoop };
    try {
      if (isNew) await call("post", "/api/routes", { body });
      else await call("put", "/api/routes/{route_id}", { path: { route_id: id }, body });
      setChanged(false);
      setError(null);
      showDone(`Route ${id} saved`);
      onSaved(body);
    } catch (refused) {
      setError(refused instanceof ApiError ? refused.message : String(refused));
      showError(`Saving route ${id}`, refused);
    }
  };
  const remove = async () => {
    const path = { route_id: route.id };
    if (await act(`Deleting route ${route.id}`, () => call("delete", "/api/routes/{route_id}", { path }))) onClose();
  };
  return (
    <Stack className={classes["builder"] ?? ""} gap="sm" data-testid="route-builder">
      <Group align="flex-end" wrap="nowrap">
        <TextInput
          label="Route"
          flex={1}
          disabled={!isNew}
          value={id}
          data-testid="route-id"
          description={isNew ? "Lower-case letters, digits, - and _" : undefined}
          onChange={(event) => setId(event.currentTarget.value)}
        />
        <Switch
          mb={8}
          label="Loop"
          checked={isLoop}
          data-testid="route-loop"
          onChange={(event) => {
            setLoop(event.currentTarget.checked);
            setChanged(true);
          }}
        />
      </Group>
      <LegList legs={legs} waypoints={ids} onChange={change} />
      {ids.length === 0 ? (
        <Text size="sm" c="dimmed">
          There is no waypoint to add. Place some on the floor first.
        </Text>
      ) : (
        <Select
          placeholder="Add a waypoint…"
          aria-label="Add a waypoint"
          searchable
          data={ids}
          value={null}
          leftSection={<IconPlus size={16} />}
          data-testid="route-add-waypoint"
          onChange={(waypoint) => waypoint !== null && add(waypoint)}
        />
      )}
      {error !== null && (
        <Alert color="red" p="xs">
          {error}
        </Alert>
      )}
      <Group justify="space-between">
        <Group gap="xs">
          <Guarded>
            <Button
              size="xs"
              leftSection={<IconDeviceFloppy size={16} />}
              disabled={!isChanged || legs.length === 0}
              data-testid="route-save"
              onClick={() => void save()}
            >
              Save
            </Button>
          </Guarded>
          <Button size="xs" variant="default" onClick={onClose}>
            Close
          </Button>
        </Group>
        {!isNew && (
          <Guarded>
            <Button
              size="xs"
              variant="subtle"
              color="red"
              leftSection={<IconTrash size={16} />}
              data-testid="route-delete"
              onClick={() => void remove()}
            >
              Delete
            </Button>
          </Guarded>
        )}
      </Group>
      {!isNew && <StartOnRobot route={route.id} isSaved={!isChanged} />}
    </Stack>
  );
}
