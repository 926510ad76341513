/** One waypoint of the table: edited in place, saved as a whole, with the API's message beside the field it refuses. */
import { ActionIcon, Button, Group, NumberInput, Popover, Select, Stack, Table, Text, TextInput } from "@mantine/core";
import { IconCheck, IconTrash, IconX } from "@tabler/icons-react";
import { useState, type KeyboardEvent } from "react";
import { showError } from "../api/action";
import { ApiError, call } from "../api/client";
import type { Waypoint } from "../api/types";
import { useLab } from "../app/lab";
import { useMay } from "../app/session";
import { removeWaypoint } from "../floor/edits";
import { degrees, radians } from "../ui/format";

interface WaypointRowProps {
  readonly waypoint: Waypoint;
  readonly isNew?: boolean;
  readonly onClose?: () => void;
}

const NUMBERS = [
  { key: "x", label: "x in metres", step: 0.05 },
  { key: "y", label: "y in metres", step: 0.05 },
  { key: "radius_m", label: "Radius in metres", step: 0.05 },
] as const;

export function WaypointRow({ waypoint, isNew = false, onClose }: WaypointRowProps) {
  const lab = useLab();
  const may = useMay("operator");
  const [edits, setEdits] = useState<Partial<Waypoint>>({});
  const [errors, setErrors] = useState<Readonly<Record<string, string>>>({});
  const edited = { ...waypoint, ...edits };
  const isDirty = isNew || Object.keys(edits).length > 0;

  const edit = (change: Partial<Waypoint>) => setEdits({ ...edits, ...change });
  const discard = () => {
    setEdits({});
    setErrors({});
    onClose?.();
  };
  const save = async () => {
    try {
      if (isNew) await call("post", "/api/waypoints", { body: edited });
      else await call("put", "/api/waypoints/{waypoint_id}", { path: { waypoint_id: waypoint.id }, body: edited });
      discard();
    } catch (error) {
      setErrors(error instanceof ApiError ? error.fields : {});
      showError(`Saving waypoint ${edited.id}`, error);
    }
  };
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === "Enter" && isDirty) void save();
    if (event.key === "Escape") discard();
  };
  return (
    <Table.Tr onKeyDown={onKeyDown} data-testid={`waypoint-${waypoint.id}`}>
      <Table.Td>
        {isNew ? (
          <TextInput
            size="xs"
            aria-label="Id"
            autoFocus
            value={edited.id}
            error={errors["id"]}
            onChange={(event) => edit({ id: event.currentTarget.value })}
          />
        ) : (
          <Text size="sm" fw={600} style={{ whiteSpace: "nowrap" }}>
            {waypoint.id}
          </Text>
        )}
      </Table.Td>
      <Table.Td>
        <Select
          size="xs"
          aria-label={`Area of ${waypoint.id}`}
          allowDeselect={false}
          disabled={!may}
          data={lab?.areas.map(({ id }) => id) ?? []}
          value={edited.area}
          error={errors["area"]}
          onChange={(area) => area !== null && edit({ area })}
        />
      </Table.Td>
      {NUMBERS.map(({ key, label, step }) => (
        <Table.Td key={key}>
          <NumberInput
            size="xs"
            hideControls
            aria-label={`${label}, ${waypoint.id}`}
            data-testid={`waypoint-${waypoint.id}-${key}`}
            disabled={!may}
            step={step}
            decimalScale={3}
            value={edited[key]}
            error={errors[key]}
            onChange={(value) => typeof value === "number" && edit({ [key]: value })}
          />
        </Table.Td>
      ))}
      <Table.Td>
        <NumberInput
          size="xs"
          hideControls
          aria-label={`Heading in degrees, ${waypoint.id}`}
          placeholder="any"
          disabled={!may}
          decimalScale={1}
          value={typeof edited.yaw === "number" ? Number(degrees(edited.yaw).toFixed(1)) : ""}
          error={errors["yaw"]}
          onChange={(value) => edit({ yaw: typeof value === "number" ? radians(value) : null })}
        />
      </Table.Td>
      <Table.Td>
        {isDirty ? (
          <Group gap={4} wrap="nowrap">
            <ActionIcon aria-label={`Save ${edited.id}`} disabled={!may} onClick={() => void save()}>
              <IconCheck size={16} />
            </ActionIcon>
            <ActionIcon aria-label={`Discard changes of ${edited.id}`} variant="default" onClick={discard}>
              <IconX size={16} />
            </ActionIcon>
          </Group>
        ) : (
          <DeleteButton waypoint={waypoint} disabled={!may} />
        )}
      </Table.Td>
    </Table.Tr>
  );
}

function DeleteButton({ waypoint, disabled }: { readonly waypoint: Waypoint; readonly disabled: boolean }) {
  const [asking, setAsking] = useState(false);
  return (
    <Popover opened={asking} onChange={setAsking} position="left" withArrow shadow="md" trapFocus>
      <Popover.Target>
        <ActionIcon
          variant="subtle"
          color="gray"
          aria-label={`Delete ${waypoint.id}`}
          disabled={disabled}
          onClick={() => setAsking(!asking)}
        >
          <IconTrash size={16} />
        </ActionIcon>
      </Popover.Target>
      <Popover.Dropdown>
        <Stack gap="xs">
          <Text size="sm">Delete waypoint {waypoint.id}?</Text>
          <Button
            size="xs"
            color="red"
            data-testid="waypoint-delete-confirm"
            onClick={() => {
              setAsking(false);
              void removeWaypoint(waypoint);
            }}
          >
            Delete
          </Button>
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
