/** The history: who did what and what went wrong, newest first, with a filter. */
import { Badge, Group, SegmentedControl, Table, Text, TextInput } from "@mantine/core";
import { IconSearch } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { showError } from "../api/action";
import { call } from "../api/client";
import type { Event, EventLevel } from "../api/types";
import { useLive } from "../live/store";
import { formatStamp } from "../ui/format";
import { Page } from "../ui/Page";
import { combined, matches } from "./history";

const LEVELS = [
  { value: "info", label: "All" },
  { value: "warning", label: "Warnings" },
  { value: "error", label: "Errors" },
];
const COLORS = { info: "gray", warning: "orange", error: "red" } as const;
const COUNT = 500;

export default function EventsPage() {
  const live = useLive(({ state }) => state.events);
  const [older, setOlder] = useState<readonly Event[]>([]);
  const [level, setLevel] = useState<EventLevel>("info");
  const [words, setWords] = useState("");
  useEffect(() => {
    call("get", "/api/events", { query: { count: COUNT } }).then(setOlder, (error: unknown) =>
      showError("Fetching the history", error),
    );
  }, []);

  const all = combined(older, live);
  const shown = all.filter((event) => matches(event, level, words));
  return (
    <Page
      title="Events"
      note="Who did what, and what went wrong. The history survives restarts."
      actions={
        <Group>
          <SegmentedControl
            size="xs"
            data={LEVELS}
            value={level}
            aria-label="Level"
            onChange={(value) => setLevel(value as EventLevel)}
          />
          <TextInput
            size="xs"
            placeholder="Robot, user, word…"
            aria-label="Filter"
            leftSection={<IconSearch size={14} />}
            value={words}
            data-testid="events-filter"
            onChange={(event) => setWords(event.currentTarget.value)}
          />
        </Group>
      }
    >
      {shown.length === 0 ? (
        <Text c="dimmed">
          {all.length === 0 ? "Nothing has happened yet." : `None of the ${all.length} events matches the filter.`}
        </Text>
      ) : (
        <Table.ScrollContainer minWidth={640}>
          <Table verticalSpacing={5} striped fz="sm" stickyHeader data-testid="events">
            <Table.Thead>
              <Table.Tr>
                <Table.Th w={170}>Time</Table.Th>
                <Table.Th w={100}>Level</Table.Th>
                <Table.Th w={150}>Source</Table.Th>
                <Table.Th>What</Table.Th>
              </Table.Tr>
            </Table.Thead>
            <Table.Tbody>
              {shown.map((event) => (
                <Table.Tr key={`${event.stamp_ns} ${event.source} ${event.text}`}>
                  <Table.Td>{formatStamp(event.stamp_ns)}</Table.Td>
                  <Table.Td>
                    <Badge size="sm" variant="light" tt="none" color={COLORS[event.level]}>
                      {event.level}
                    </Badge>
                  </Table.Td>
                  <Table.Td>{event.source}</Table.Td>
                  <Table.Td>
                    {event.text}{" "}
                    <Text span size="xs" c="dimmed">
                      {event.kind}
                    </Text>
                  </Table.Td>
                </Table.Tr>
              ))}
            </Table.Tbody>
          </Table>
        </Table.ScrollContainer>
      )}
    </Page>
  );
}
