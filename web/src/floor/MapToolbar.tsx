/** The tools on the map: place waypoints, choose layers, zoom, show everything, follow the selected robot. */
import { ActionIcon, Button, Checkbox, Group, Popover, Stack, Tooltip } from "@mantine/core";
import { IconFocus2, IconMapPinPlus, IconMaximize, IconMinus, IconPlus, IconStack2 } from "@tabler/icons-react";
import type { RefObject } from "react";
import { Guarded } from "../ui/Guarded";
import classes from "./floor.module.css";
import { LAYERS, setFollows, setMode, toggleLayer, useFloor, type LayerName } from "./floor-state";
import type { FloorMap } from "./FloorMap";

const ZOOM_STEP = 1.5;

export function MapToolbar({ mapRef }: { readonly mapRef: RefObject<FloorMap | null> }) {
  const { mode, robot, follows } = useFloor();
  const isPlacing = mode === "place";
  return (
    <>
      <Group className={classes["tools"] ?? ""} gap={6}>
        <Guarded hint="Each click on the map places a waypoint (Esc ends it)">
          <Button
            variant={isPlacing ? "filled" : "default"}
            size="xs"
            leftSection={<IconMapPinPlus size={16} />}
            aria-pressed={isPlacing}
            data-testid="place-waypoints"
            onClick={() => setMode(isPlacing ? "select" : "place")}
          >
            {isPlacing ? "Click the map…" : "Place waypoints"}
          </Button>
        </Guarded>
        <Layers />
      </Group>
      <Stack className={classes["view"] ?? ""} gap={6}>
        <Tool label="Zoom in" onClick={() => mapRef.current?.zoom(ZOOM_STEP)}>
          <IconPlus size={18} />
        </Tool>
        <Tool label="Zoom out" onClick={() => mapRef.current?.zoom(1 / ZOOM_STEP)}>
          <IconMinus size={18} />
        </Tool>
        <Tool label="Show the whole floor" onClick={() => mapRef.current?.fit()}>
          <IconMaximize size={18} />
        </Tool>
        <Tool
          label={robot === null ? "Select a robot to follow it" : `Follow ${robot}`}
          isOn={follows}
          disabled={robot === null}
          onClick={() => {
            if (robot !== null) mapRef.current?.centreOn(robot, true);
            setFollows(!follows);
          }}
        >
          <IconFocus2 size={18} />
        </Tool>
      </Stack>
    </>
  );
}

interface ToolProps {
  readonly label: string;
  readonly isOn?: boolean;
  readonly disabled?: boolean;
  readonly onClick: () => void;
  readonly children: React.ReactNode;
}

function Tool({ label, isOn = false, disabled = false, onClick, children }: ToolProps) {
  return (
    <Tooltip label={label} position="left">
      <ActionIcon
        variant={isOn ? "filled" : "default"}
        size={34}
        aria-label={label}
        aria-pressed={isOn}
        disabled={disabled}
        onClick={onClick}
      >
        {children}
      </ActionIcon>
    </Tooltip>
  );
}

function Layers() {
  const layers = useFloor((floor) => floor.layers);
  return (
    <Popover position="bottom-start" shadow="md">
      <Popover.Target>
        <Button variant="default" size="xs" leftSection={<IconStack2 size={16} />} data-testid="layers">
          Layers
        </Button>
      </Popover.Target>
      <Popover.Dropdown>
        <Stack gap="xs">
          {(Object.keys(LAYERS) as LayerName[]).map((name) => (
            <Checkbox
              key={name}
              size="sm"
              label={LAYERS[name]}
              checked={layers[name]}
              data-testid={`layer-${name}`}
              onChange={() => toggleLayer(name)}
            />
          ))}
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
