/** Every channel that something should be heard on, and how old its newest message is. */
import { Badge, Table } from "@mantine/core";
import type { ChannelView } from "../api/types";
import { formatDuration, formatStamp } from "../ui/format";

const COLORS = { ok: "teal", warn: "orange", stale: "red", missing: "red", idle: "gray" } as const;

export function ChannelTable({ channels }: { readonly channels: readonly ChannelView[] }) {
  return (
    <Table.ScrollContainer minWidth={420}>
      <Table verticalSpacing={3} fz="sm" data-testid="channels">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Channel</Table.Th>
            <Table.Th>Of</Table.Th>
            <Table.Th>Condition</Table.Th>
            <Table.Th ta="right">Age</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {channels.map((channel) => (
            <Table.Tr key={`${channel.channel} ${channel.instance}`}>
              <Table.Td>{channel.channel}</Table.Td>
              <Table.Td>{channel.instance}</Table.Td>
              <Table.Td>
                <Badge size="sm" variant="dot" tt="none" color={COLORS[channel.condition]}>
                  {channel.condition}
                </Badge>
              </Table.Td>
              <Table.Td ta="right">{describeAge(channel)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

function describeAge({ age_s, since_ns, producer }: ChannelView): string {
  if (age_s === null) return `never, from ${producer}`;
  return since_ns === null ? formatDuration(age_s * 1000) : `since ${formatStamp(since_ns)}`;
}
