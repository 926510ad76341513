/** How the system itself does: processes, channels and their ages, datagrams. */
import { Alert, Paper, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { useLive } from "../live/store";
import { formatStamp } from "../ui/format";
import { Page } from "../ui/Page";
import { ChannelTable } from "./ChannelTable";
import { DatagramCounts } from "./DatagramCounts";
import { ProcessTable } from "./ProcessTable";

export default function SystemPage() {
  const health = useLive((live) => live.state.health);
  return (
    <Page title="System" note={health && `The server runs since ${formatStamp(health.started_ns)}.`}>
      {!health && <Text c="dimmed">Waiting for the first message of the server…</Text>}
      {health && !health.redis.reachable && (
        <Alert color="red" title="Redis does not answer">
          {health.redis.since_ns !== null && `Since ${formatStamp(health.redis.since_ns)}. `}
          Robots stop by themselves; nothing that was configured is lost.
        </Alert>
      )}
      {health && (
        <SimpleGrid cols={{ base: 1, lg: 2 }} spacing="lg">
          <Stack>
            <Paper withBorder p="md">
              <Title order={2} fz="h5" mb="sm">
                Processes
              </Title>
              <ProcessTable processes={health.processes} />
            </Paper>
            <Paper withBorder p="md">
              <Title order={2} fz="h5" mb="sm">
                Datagrams from robots
              </Title>
              <DatagramCounts udp={health.udp} />
            </Paper>
          </Stack>
          <Paper withBorder p="md">
            <Title order={2} fz="h5" mb="sm">
              Channels
            </Title>
            <ChannelTable channels={health.channels} />
          </Paper>
        </SimpleGrid>
      )}
    </Page>
  );
}
