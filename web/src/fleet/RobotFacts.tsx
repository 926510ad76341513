/** Numbers of a robot: the cameras' pose beside its own, and how it is connected. */
import { Table } from "@mantine/core";
import type { RobotView } from "../api/types";
import { degrees, formatStamp, withSince } from "../ui/format";

function place(at: { x: number | null; y: number | null; yaw: number | null } | null): string {
  if (typeof at?.x !== "number" || at.y === null || at.yaw === null) return "unknown";
  return `${at.x.toFixed(3)}, ${at.y.toFixed(3)} m, ${degrees(at.yaw).toFixed(1)}°`;
}

type Reason = NonNullable<RobotView["reason"]>;

function said(reason: Reason | null | undefined): string {
  if (!reason) return "no";
  return withSince({ text: reason.text || reason.code, since_ns: reason.since_ns ?? null });
}

function lost(share: number | null | undefined): string {
  return typeof share === "number" ? `${Math.round(share * 100)} %` : "unknown";
}

export function RobotFacts({ robot }: { readonly robot: RobotView }) {
  const { pose, status, command } = robot;
  const rows: [string, string][] = [
    ["Seen by cameras", place(pose)],
    ["Cameras", pose?.cameras.join(", ") ?? "none"],
    ["Position spread", pose ? `${(pose.position_std_m * 1000).toFixed(1)} mm` : "unknown"],
    ["Believes itself", place(status)],
    ["Command", command ? `${command.movement} at ${command.speed_mps.toFixed(2)} m/s` : "none fresh"],
    ["Stands", said(robot.reason)],
    ["Held by itself", said(status?.stopped_by)],
    ["Lost on the way", `${lost(status?.loss)} of statuses, ${lost(status?.command_loss)} of commands`],
    ["Connection", robot.connection.toLowerCase().replace("_", " ")],
    ["Last heard", robot.last_heard_ns === null ? "never" : formatStamp(robot.last_heard_ns)],
    ["Address", status?.ip ?? "unknown"],
    ["Area", pose?.area ?? "outside"],
  ];
  return (
    <Table variant="vertical" fz="xs" verticalSpacing={4} layout="fixed">
      <Table.Tbody>
        {rows.map(([name, value]) => (
          <Table.Tr key={name}>
            <Table.Th w={120}>{name}</Table.Th>
            <Table.Td>{value}</Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}
