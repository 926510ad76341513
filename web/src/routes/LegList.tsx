/** The legs of a route in order: each one ends at a waypoint and has its own speed. */
import { ActionIcon, Badge, Group, NumberInput, Select, Stack } from "@mantine/core";
import { IconArrowDown, IconArrowUp, IconX } from "@tabler/icons-react";
import type { Leg } from "../api/types";

export interface DraftLeg extends Leg {
  readonly key: string;
}

interface LegListProps {
  readonly legs: readonly DraftLeg[];
  readonly waypoints: readonly string[];
  readonly onChange: (legs: DraftLeg[]) => void;
}

/** The list with two neighbours swapped. */
export function swapped<T>(list: readonly T[], index: number, other: number): T[] {
  const copy = [...list];
  const [a, b] = [copy[index], copy[other]];
  if (a === undefined || b === undefined) return copy;
  copy[index] = b;
  copy[other] = a;
  return copy;
}

export function LegList({ legs, waypoints, onChange }: LegListProps) {
  const edit = (index: number, change: Partial<Leg>) =>
    onChange(legs.map((leg, at) => (at === index ? { ...leg, ...change } : leg)));
  return (
    <Stack gap={6} data-testid="legs">
      {legs.map((leg, index) => (
        <Group key={leg.key} gap={6} wrap="nowrap">
          <Badge variant="default" circle size="lg">
            {index + 1}
          </Badge>
          <Select
            size="xs"
            flex={1}
            aria-label={`Waypoint of leg ${index + 1}`}
            allowDeselect={false}
            data={waypoints.includes(leg.waypoint) ? waypoints : [leg.waypoint, ...waypoints]}
            value={leg.waypoint}
            error={waypoints.includes(leg.waypoint) ? undefined : "does not exist"}
            onChange={(waypoint) => waypoint !== null && edit(index, { waypoint })}
          />
          <NumberInput
            size="xs"
            w={104}
            aria-label={`Speed of leg ${index + 1}`}
            suffix=" m/s"
            min={0.05}
            max={10}
            step={0.05}
            decimalScale={2}
            value={leg.speed_mps}
            onChange={(speed) => typeof speed === "number" && edit(index, { speed_mps: speed })}
          />
          <ActionIcon
            variant="subtle"
            color="gray"
            aria-label={`Leg ${index + 1} earlier`}
            disabled={index === 0}
            onClick={() => onChange(swapped(legs, index, index - 1))}
          >
            <IconArrowUp size={16} />
          </ActionIcon>
          <ActionIcon
            variant="subtle"
            color="gray"
            aria-label={`Leg ${index + 1} later`}
            disabled={index === legs.length - 1}
            onClick={() => onChange(swapped(legs, index, index + 1))}
          >
            <IconArrowDown size={16} />
          </ActionIcon>
          <ActionIcon
            variant="subtle"
            color="gray"
            aria-label={`Remove leg ${index + 1}`}
            onClick={() => onChange(legs.filter((_, at) => at !== index))}
          >
            <IconX size={16} />
          </ActionIcon>
        </Group>
      ))}
    </Stack>
  );
}
