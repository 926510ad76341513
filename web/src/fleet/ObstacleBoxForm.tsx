/** The obstacle box of a robot: where it starts, how long and wide it is, and whether it ends at the next waypoint. */
import { Button, Group, NumberInput, SimpleGrid, Stack, Switch, Text } from "@mantine/core";
import { useState } from "react";
import { act, showDone } from "../api/action";
import { call } from "../api/client";
import type { ObstacleBox, RobotSettings, RobotView } from "../api/types";
import { Guarded } from "../ui/Guarded";

const FIELDS = [
  { key: "start_m", label: "Start", minimum: 0 },
  { key: "length_m", label: "Length", minimum: 0.05 },
  { key: "width_m", label: "Width", minimum: 0.05 },
] as const;

const LAB_DEFAULTS = {
  box_start_m: null,
  box_length_m: null,
  box_width_m: null,
  stop_at_waypoint: null,
};

const BOX_SETTINGS = ["box_start_m", "box_length_m", "box_width_m", "stop_at_waypoint"] as const;

export function ObstacleBoxForm({ robot }: { readonly robot: RobotView }) {
  const [edits, setEdits] = useState<Partial<ObstacleBox>>({});
  const box = { ...robot.obstacle_box, ...edits };
  const isSet = BOX_SETTINGS.some((key) => robot.settings[key] !== null);

  const save = async (settings: RobotSettings) => {
    const done = await act(`The obstacle box of ${robot.id}`, () =>
      call("put", "/api/robots/{robot_id}/settings", { path: { robot_id: robot.id }, body: settings }),
    );
    if (!done) return;
    setEdits({});
    showDone(`Obstacle box of ${robot.id} changed`);
  };
  const settings: RobotSettings = {
    ...robot.settings,
    box_start_m: box.start_m,
    box_length_m: box.length_m,
    box_width_m: box.width_m,
    stop_at_waypoint: box.stop_at_waypoint,
  };
  return (
    <Stack gap="sm">
      <Text size="xs" c="dimmed">
        In metres along the path, from the robot&apos;s rotation centre. Anything red inside makes it wait.
      </Text>
      <SimpleGrid cols={3} spacing="xs">
        {FIELDS.map(({ key, label, minimum }) => (
          <NumberInput
            key={key}
            label={label}
            size="xs"
            min={minimum}
            max={10}
            step={0.05}
            decimalScale={2}
            value={box[key]}
            data-testid={`box-${key}`}
            onChange={(value) => typeof value === "number" && setEdits({ ...edits, [key]: value })}
          />
        ))}
      </SimpleGrid>
      <Switch
        label="Ends at the next waypoint"
        checked={box.stop_at_waypoint}
        onChange={(event) => setEdits({ ...edits, stop_at_waypoint: event.currentTarget.checked })}
      />
      <Group justify="space-between">
        <Guarded>
          <Button
            size="xs"
            variant="subtle"
            disabled={!isSet}
            onClick={() => void save({ ...robot.settings, ...LAB_DEFAULTS })}
          >
            Back to the lab&apos;s
          </Button>
        </Guarded>
        <Guarded>
          <Button
            size="xs"
            disabled={Object.keys(edits).length === 0}
            data-testid="box-save"
            onClick={() => void save(settings)}
          >
            Apply
          </Button>
        </Guarded>
      </Group>
    </Stack>
  );
}
