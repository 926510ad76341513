/** The processes of the system: what runs, how often it was restarted, and how it ended the last time. */
import { Badge, Table, Text } from "@mantine/core";
import type { ProcessState } from "../api/types";
import { formatStamp } from "../ui/format";

const COLORS = { running: "teal", starting: "steel", restarting: "orange", stopped: "red" } as const;

export function ProcessTable({ processes }: { readonly processes: readonly ProcessState[] }) {
  if (processes.length === 0)
    return (
      <Text size="sm" c="dimmed">
        No launcher has reported its processes. They are listed when the system was started with ./lilliput up.
      </Text>
    );
  return (
    <Table.ScrollContainer minWidth={420}>
      <Table verticalSpacing={5} fz="sm" data-testid="processes">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Process</Table.Th>
            <Table.Th>State</Table.Th>
            <Table.Th>Since</Table.Th>
            <Table.Th ta="right">Restarts</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {processes.map((process) => (
            <Table.Tr key={process.name}>
              <Table.Td>
                {process.name}
                {process.last_error && (
                  <Text size="xs" c="dimmed">
                    {process.last_error}
                  </Text>
                )}
              </Table.Td>
              <Table.Td>
                <Badge variant="dot" tt="none" color={COLORS[process.state]}>
                  {process.state}
                </Badge>
              </Table.Td>
              <Table.Td>{formatStamp(process.since_ns)}</Table.Td>
              <Table.Td ta="right" {...(process.restarts > 0 && { c: "orange", fw: 600 })}>
                {process.restarts}
              </Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}
