/** Third step: what would change, in pixels and millimetres, and the decision. */
import { Alert, Badge, Button, Group, Paper, Stack, Table, Text, Title } from "@mantine/core";
import { IconAlertTriangle, IconCheck, IconTrash } from "@tabler/icons-react";
import { act, showDone } from "../api/action";
import { call } from "../api/client";
import type { CalibrationProposal, CameraComparison } from "../api/types";
import { Guarded } from "../ui/Guarded";
import { byShift, formatMm, formatPx, formatTurn, verdictOf, type Verdict } from "./stage";

const VERDICTS: Readonly<Record<Verdict, { readonly color: string; readonly text: string }>> = {
  first: { color: "blue", text: "first calibration" },
  better: { color: "teal", text: "better" },
  same: { color: "gray", text: "as before" },
  worse: { color: "orange", text: "worse" },
};

interface CompareStepProps {
  readonly proposal: CalibrationProposal;
  /** Why some cameras are missing; empty when none is. */
  readonly note: string;
  readonly onDecided: () => Promise<void>;
}

export function CompareStep({ proposal, note, onDecided }: CompareStepProps) {
  const body = { id: proposal.calibration.id };
  const accept = async () => {
    if (await act("Accepting the calibration", () => call("post", "/api/calibration/accept", { body })))
      showDone("The new calibration is in force. “Restore previous” takes it back.");
    await onDecided();
  };
  const discard = async () => {
    if (await act("Discarding the calibration", () => call("post", "/api/calibration/discard", { body })))
      showDone("Discarded; nothing has changed.");
    await onDecided();
  };
  return (
    <Stack data-testid="calibration-proposal" data-id={proposal.calibration.id}>
      <Group justify="space-between" align="center">
        <Text size="sm" maw={720}>
          Nothing has changed yet. <b>Off</b> is how far floor tags appear from where the calibration puts them: small
          is good, below 0.3 pixels as it should be. <b>Poses move</b> says by how much robots will seem to jump when
          you accept.
        </Text>
        <Group gap="sm">
          <Guarded>
            <Button
              variant="default"
              leftSection={<IconTrash size={16} />}
              data-testid="calibration-discard"
              onClick={() => void discard()}
            >
              Discard
            </Button>
          </Guarded>
          <Guarded>
            <Button
              color="teal"
              leftSection={<IconCheck size={16} />}
              data-testid="calibration-accept"
              onClick={() => void accept()}
            >
              Accept
            </Button>
          </Guarded>
        </Group>
      </Group>
      {note !== "" && (
        <Alert color="orange" icon={<IconAlertTriangle />} title="Not every camera took part">
          {note}. What it saw the last time is used instead.
        </Alert>
      )}
      <Paper withBorder p="md">
        <Title order={2} fz="h5" mb="sm">
          Cameras
        </Title>
        <CameraTable cameras={proposal.cameras} />
      </Paper>
      <Paper withBorder p="md">
        <Title order={2} fz="h5">
          Floor tags
        </Title>
        <Text size="xs" c="dimmed" mb="sm">
          A tag that is moved by much more than the others was measured wrongly, or lies somewhere else by now.
        </Text>
        <FloorTagTable proposal={proposal} />
      </Paper>
    </Stack>
  );
}

function CameraTable({ cameras }: { readonly cameras: Readonly<Record<string, CameraComparison>> }) {
  return (
    <Table.ScrollContainer minWidth={820}>
      <Table verticalSpacing={6} fz="sm" data-testid="calibration-cameras">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Camera</Table.Th>
            <Table.Th>Floor tags</Table.Th>
            <Table.Th>Off before</Table.Th>
            <Table.Th>Off after</Table.Th>
            <Table.Th>Poses move (mean, most)</Table.Th>
            <Table.Th>Camera moved, turned</Table.Th>
            <Table.Th>Uncertain by (before, after)</Table.Th>
            <Table.Th />
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {Object.entries(cameras).map(([id, camera]) => {
            const verdict = VERDICTS[verdictOf(camera)];
            return (
              <Table.Tr key={id} data-testid={`calibration-camera-${id}`}>
                <Table.Td fw={600}>
                  {id}
                  <Text size="xs" c="dimmed">
                    {camera.is_new ? `${camera.frames} frames` : "as seen before"}
                  </Text>
                </Table.Td>
                <Table.Td>
                  {camera.floor_tags.join(", ")}
                  {camera.left_out.length > 0 && (
                    <Text size="xs" c="orange">
                      not believed: {camera.left_out.join(", ")}
                    </Text>
                  )}
                </Table.Td>
                <Table.Td>{formatPx(camera.reprojection_before_px)}</Table.Td>
                <Table.Td fw={600}>{formatPx(camera.reprojection_after_px)}</Table.Td>
                <Table.Td>
                  {formatMm(camera.floor_shift_mean_m)}, {formatMm(camera.floor_shift_max_m)}
                </Table.Td>
                <Table.Td>
                  {formatMm(camera.camera_moved_m)}, {formatTurn(camera.camera_turned_rad)}
                </Table.Td>
                <Table.Td>
                  {formatMm(camera.floor_std_before_m)}, {formatMm(camera.floor_std_after_m)}
                </Table.Td>
                <Table.Td>
                  <Badge variant="light" tt="none" color={verdict.color}>
                    {verdict.text}
                  </Badge>
                </Table.Td>
              </Table.Tr>
            );
          })}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

function FloorTagTable({ proposal }: { readonly proposal: CalibrationProposal }) {
  return (
    <Table.ScrollContainer minWidth={420}>
      <Table verticalSpacing={4} fz="sm" data-testid="calibration-floor-tags">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Tag</Table.Th>
            <Table.Th>Seen by</Table.Th>
            <Table.Th>Moved by</Table.Th>
            <Table.Th>From the lab file</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {byShift(proposal.floor_tags).map(([id, tag]) => (
            <Table.Tr key={id}>
              <Table.Td fw={600}>{id}</Table.Td>
              <Table.Td>{tag.cameras.length > 0 ? tag.cameras.join(", ") : "no camera"}</Table.Td>
              <Table.Td>{formatMm(tag.shift_m)}</Table.Td>
              <Table.Td>{formatMm(proposal.calibration.floor_tags[id]?.shift_m ?? null)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}
