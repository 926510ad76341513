/** All robots of the lab, the selected one with everything that can be done with it. */
import { Text } from "@mantine/core";
import { useLive } from "../live/store";
import { RobotRow } from "./RobotRow";

interface RobotListProps {
  readonly selected: string | null;
  readonly onSelect: (robot: string) => void;
}

export function RobotList({ selected, onSelect }: RobotListProps) {
  const robots = useLive((live) => live.state.robots);
  const known = useLive((live) => live.known);
  const list = Object.values(robots);
  if (list.length === 0)
    return (
      <Text p="md" size="sm" c="dimmed">
        {known
          ? "The lab description lists no vehicles. Add them under `vehicles` in the lab file and start again."
          : "Waiting for the first message of the server…"}
      </Text>
    );
  return (
    <div role="group" aria-label="Robots" data-testid="robot-list">
      {list.map((robot) => (
        <RobotRow key={robot.id} robot={robot} isSelected={robot.id === selected} onSelect={onSelect} />
      ))}
    </div>
  );
}
