/** Everything about the selected robot: its route, driving it by hand, its obstacle box, and what it says of itself. */
import { Accordion, Group, Text } from "@mantine/core";
import { useState } from "react";
import type { RobotView } from "../api/types";
import { AssignmentControls } from "./AssignmentControls";
import { ManualDrive } from "./ManualDrive";
import { ObstacleBoxForm } from "./ObstacleBoxForm";
import { RobotFacts } from "./RobotFacts";

const COMPACT = { label: { paddingBlock: 10, fontSize: "var(--mantine-font-size-sm)", fontWeight: 600 } };

export function RobotPanel({ robot }: { readonly robot: RobotView }) {
  const [opened, setOpened] = useState<string[]>(["route", "manual"]);
  const sections = [
    { value: "route", title: "Route", content: <AssignmentControls robot={robot} /> },
    { value: "manual", title: "Drive by hand", content: <ManualDrive key={robot.id} robot={robot} /> },
    { value: "box", title: "Obstacle box", content: <ObstacleBoxForm key={robot.id} robot={robot} /> },
    { value: "facts", title: "Details", content: <RobotFacts robot={robot} /> },
  ];
  return (
    <section aria-label={`Robot ${robot.id}`} data-testid="robot-panel" data-robot={robot.id}>
      <Group px="md" pt="md" pb={4} justify="space-between">
        <Text fw={700}>{robot.id}</Text>
        <Text size="sm" c="dimmed">
          {robot.kind}
        </Text>
      </Group>
      <Accordion multiple value={opened} onChange={setOpened} chevronPosition="left" styles={COMPACT}>
        {sections.map(({ value, title, content }) => (
          <Accordion.Item key={value} value={value}>
            <Accordion.Control data-testid={`section-${value}`}>{title}</Accordion.Control>
            <Accordion.Panel>{opened.includes(value) && content}</Accordion.Panel>
          </Accordion.Item>
        ))}
      </Accordion>
    </section>
  );
}
