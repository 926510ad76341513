/** First step: do the cameras see their floor tags? Which of them are to be calibrated? */
import { Alert, Button, Card, Checkbox, Group, SimpleGrid, Text } from "@mantine/core";
import { IconTargetArrow } from "@tabler/icons-react";
import { useState } from "react";
import { act } from "../api/action";
import { call } from "../api/client";
import type { CameraView } from "../api/types";
import { Preview } from "../cameras/Preview";
import { useLive } from "../live/store";
import { Guarded } from "../ui/Guarded";
import { describeTags, formatPx } from "./stage";

export function LookStep({ onStarted }: { readonly onStarted: () => Promise<void> }) {
  const cameras = Object.values(useLive((live) => live.state.cameras));
  const known = useLive((live) => live.known);
  const [left, setLeft] = useState<ReadonlySet<string>>(new Set());
  const chosen = cameras.map(({ id }) => id).filter((id) => !left.has(id));
  const choose = (id: string, isChosen: boolean) => {
    const next = new Set(left);
    if (isChosen) next.delete(id);
    else next.add(id);
    setLeft(next);
  };
  const start = async () => {
    if (await act("Starting the calibration", () => call("post", "/api/calibration", { body: { cameras: chosen } })))
      await onStarted();
  };
  if (cameras.length === 0)
    return (
      <Text c="dimmed">
        {known
          ? "There is no camera to calibrate. Add cameras to the lab file and start again."
          : "Waiting for the first message of the server…"}
      </Text>
    );
  return (
    <>
      <Group justify="space-between" align="center" gap="md">
        <Text size="sm" maw={720}>
          Clear the floor tags: nothing should lie on them or shade half of one. A camera needs at least two, four or
          more make it certain, and those that two cameras share tie them together. Robots may go on driving.
        </Text>
        <Guarded>
          <Button
            leftSection={<IconTargetArrow size={18} />}
            disabled={chosen.length === 0}
            data-testid="calibration-start"
            onClick={() => void start()}
          >
            Calibrate {chosen.length} {chosen.length === 1 ? "camera" : "cameras"}
          </Button>
        </Guarded>
      </Group>
      <SimpleGrid cols={{ base: 1, xs: 2, lg: 4 }} spacing="md">
        {cameras.map((camera) => (
          <CameraChoice
            key={camera.id}
            camera={camera}
            isChosen={!left.has(camera.id)}
            onChange={(isChosen) => choose(camera.id, isChosen)}
          />
        ))}
      </SimpleGrid>
    </>
  );
}

interface CameraChoiceProps {
  readonly camera: CameraView;
  readonly isChosen: boolean;
  readonly onChange: (isChosen: boolean) => void;
}

function CameraChoice({ camera, isChosen, onChange }: CameraChoiceProps) {
  const { id, state } = camera;
  const tags = describeTags(state?.fresh ? state.floor_tags_seen : []);
  const wrong = !state?.fresh ? "Nothing is heard from this camera" : state.error;
  return (
    <Card withBorder padding="sm" data-testid={`calibration-look-${id}`}>
      <Card.Section>
        <Preview camera={id} ratio={camera.width / camera.height} />
      </Card.Section>
      <Checkbox
        mt="sm"
        fw={600}
        label={id}
        checked={isChosen}
        onChange={(event) => onChange(event.currentTarget.checked)}
      />
      <Text size="sm" mt={4} {...(!tags.isEnough && { c: "orange" })}>
        {tags.text}
      </Text>
      <Text size="xs" c="dimmed">
        {typeof state?.reprojection_px === "number" ? `Now ${formatPx(state.reprojection_px)} off` : "Not calibrated"}
      </Text>
      {wrong && (
        <Alert color="red" p="xs" mt="xs">
          {wrong}
        </Alert>
      )}
    </Card>
  );
}
