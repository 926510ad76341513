/** What each camera sees and how well. */
import { Button, SimpleGrid, Text } from "@mantine/core";
import { IconTargetArrow } from "@tabler/icons-react";
import { Link } from "react-router";
import { useLive } from "../live/store";
import { Page } from "../ui/Page";
import { CameraCard } from "./CameraCard";

export default function CamerasPage() {
  const cameras = useLive((live) => live.state.cameras);
  const known = useLive((live) => live.known);
  const list = Object.values(cameras);
  return (
    <Page
      title="Cameras"
      note="Pictures are fetched only while they are in sight."
      actions={
        <Button component={Link} to="/calibration" variant="default" leftSection={<IconTargetArrow size={16} />}>
          Calibrate
        </Button>
      }
    >
      {list.length === 0 && (
        <Text c="dimmed">
          {known
            ? "The lab description lists no cameras. Add them under `cameras` in the lab file and start again."
            : "Waiting for the first message of the server…"}
        </Text>
      )}
      <SimpleGrid cols={{ base: 1, sm: 2, xl: 3 }} spacing="md">
        {list.map((camera) => (
          <CameraCard key={camera.id} camera={camera} />
        ))}
      </SimpleGrid>
    </Page>
  );
}
