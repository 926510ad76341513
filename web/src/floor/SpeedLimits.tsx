/** The legend of the zones with a speed limit: which there are, and how fast robots may be in each. */
import { Group, Paper, Stack, Text, useComputedColorScheme } from "@mantine/core";
import { useLive } from "../live/store";
import { formatSpeed } from "../ui/format";
import classes from "./floor.module.css";
import { useFloor } from "./floor-state";
import { paletteOf } from "./palette";

/** How many zones are listed; the others are counted. */
const MOST_LINES = 6;

export function SpeedLimits() {
  const shown = useFloor((floor) => floor.layers.speeds);
  const zones = useLive((live) => live.state.speed_zones);
  const palette = paletteOf(useComputedColorScheme());
  const listed = Object.values(zones).sort((a, b) => a.id.localeCompare(b.id));
  if (!shown || listed.length === 0) return null;
  return (
    <Paper className={classes["legend"] ?? ""} p="xs" shadow="xs" withBorder data-testid="speed-limits">
      <Stack gap={4}>
        <Text size="xs" fw={600}>
          Speed limits
        </Text>
        {listed.slice(0, MOST_LINES).map(({ id, speed_mps }) => (
          <Group key={id} gap={6} wrap="nowrap">
            <span
              className={classes["swatch"]}
              style={{ background: palette.speedFill, borderColor: palette.speed }}
              aria-hidden
            />
            <Text size="xs">
              {id}: at most {formatSpeed(speed_mps)}
            </Text>
          </Group>
        ))}
        {listed.length > MOST_LINES && (
          <Text size="xs" c="dimmed">
            and {listed.length - MOST_LINES} more
          </Text>
        )}
      </Stack>
    </Paper>
  );
}
