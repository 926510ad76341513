/** What is in force, how to keep it as a file, and the way back to what was before. */
import { Button, Group, Paper, Text, Title } from "@mantine/core";
import { IconArrowBackUp, IconDownload } from "@tabler/icons-react";
import { act, showDone } from "../api/action";
import { call } from "../api/client";
import type { Calibration } from "../api/types";
import { formatStamp } from "../ui/format";
import { Guarded } from "../ui/Guarded";
import { formatPx } from "./stage";

interface InForceProps {
  readonly current: Calibration | null;
  readonly previous: Calibration | null;
  readonly onChanged: () => Promise<void>;
}

export function InForce({ current, previous, onChanged }: InForceProps) {
  const restore = async () => {
    if (await act("Restoring the previous calibration", () => call("post", "/api/calibration/restore")))
      showDone("The previous calibration is in force again.");
    await onChanged();
  };
  return (
    <Paper withBorder p="md" data-testid="calibration-in-force" data-id={current?.id ?? ""}>
      <Group justify="space-between">
        <div>
          <Title order={2} fz="h5">
            In force
          </Title>
          <Text size="sm">
            {current
              ? describe(current)
              : "No joint calibration yet: it is made by itself as soon as every camera sees its floor tags."}
          </Text>
          {previous && (
            <Text size="xs" c="dimmed">
              Before: {describe(previous)}
            </Text>
          )}
        </div>
        <Group gap="sm">
          {current && (
            <Button
              component="a"
              variant="default"
              leftSection={<IconDownload size={16} />}
              href={`data:application/json,${encodeURIComponent(JSON.stringify(current, null, 2))}`}
              download={`calibration-${current.id}.json`}
            >
              Save as file
            </Button>
          )}
          {previous && (
            <Guarded hint="Done twice, it undoes itself.">
              <Button
                variant="default"
                leftSection={<IconArrowBackUp size={16} />}
                data-testid="calibration-restore"
                onClick={() => void restore()}
              >
                Restore previous
              </Button>
            </Guarded>
          )}
        </Group>
      </Group>
    </Paper>
  );
}

function describe({ by, cameras, floor_tags, stamp_ns }: Calibration): string {
  const worst = Math.max(0, ...Object.values(cameras).map(({ reprojection_px }) => reprojection_px));
  const who = by === "calibrator" ? "made by itself" : `accepted by ${by}`;
  const names = Object.keys(cameras).join(", ");
  return `${names} with ${Object.keys(floor_tags).length} floor tags, at most ${formatPx(worst)} off; since ${formatStamp(stamp_ns)}, ${who}`;
}
