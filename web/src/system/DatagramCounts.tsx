/** What became of the datagrams that robots sent. */
import { Alert, Group, Text } from "@mantine/core";
import type { UdpView } from "../api/types";

const REFUSED = [
  ["undecodable", "undecodable or forged"],
  ["wrong_kind", "of a wrong kind"],
  ["unknown_robot", "of unknown robots"],
  ["wrong_sender", "of a wrong sender"],
  ["old", "too old"],
  ["future", "from the future"],
  ["duplicate", "twice"],
  ["out_of_order", "out of order"],
] as const;

export function DatagramCounts({ udp }: { readonly udp: UdpView }) {
  if (!udp.listening)
    return <Alert color="red">Nobody listens for robots: the intake does not run; is its UDP port in use?</Alert>;
  const refused = REFUSED.filter(([key]) => udp[key] > 0);
  return (
    <>
      <Group gap="lg">
        <Text size="sm">{udp.received.toLocaleString("en-GB")} received</Text>
        <Text size="sm">{udp.accepted.toLocaleString("en-GB")} accepted</Text>
        {refused.map(([key, text]) => (
          <Text key={key} size="sm" c="orange">
            {udp[key].toLocaleString("en-GB")} {text}
          </Text>
        ))}
      </Group>
      {udp.last_problem !== null && (
        <Text size="xs" c="dimmed" mt={4}>
          Last refused: {udp.last_problem}
        </Text>
      )}
    </>
  );
}
