/** What can be taken back with Ctrl + Z on the floor page: the newest changes first. */
import { Button, Group, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";

interface Step {
  readonly id: string;
  readonly undo: () => Promise<unknown>;
}

const KEPT = 20;
const steps: Step[] = [];
let count = 0;

/** Remembers a change and offers to take it back. */
export function offerUndo(text: string, undo: () => Promise<unknown>): void {
  count += 1;
  const step = { id: `undo-${count}`, undo };
  const before = steps.at(-1);
  if (before) notifications.hide(before.id);
  steps.push(step);
  if (steps.length > KEPT) steps.shift();
  notifications.show({
    id: step.id,
    message: (
      <Group justify="space-between" wrap="nowrap">
        <Text size="sm">{text}</Text>
        <Button size="compact-xs" variant="light" data-testid="undo" onClick={() => void takeBack(step)}>
          Undo
        </Button>
      </Group>
    ),
    autoClose: 6000,
    color: "teal",
    "data-testid": "toast-undo",
  });
}

/** Takes the newest change back. */
export function undoNewest(): void {
  const newest = steps.at(-1);
  if (newest) void takeBack(newest);
}

async function takeBack(step: Step): Promise<void> {
  const index = steps.indexOf(step);
  if (index < 0) return;
  steps.splice(index, 1);
  notifications.hide(step.id);
  await step.undo();
}
