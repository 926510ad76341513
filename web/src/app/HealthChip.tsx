/** The health of the whole in one chip; a click tells what is missing since when. */
import { Badge, UnstyledButton } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { IconAlertTriangleFilled, IconCircleCheckFilled } from "@tabler/icons-react";
import { useLive } from "../live/store";
import { HealthDrawer } from "./HealthDrawer";

const COLORS = { ok: "teal", warning: "orange", error: "red" } as const;

export function HealthChip() {
  const health = useLive((live) => live.state.health);
  const [opened, { open, close }] = useDisclosure(false);
  if (!health) return null;
  const count = health.problems.length;
  const text = count === 0 ? "All well" : count === 1 ? "1 problem" : `${count} problems`;
  return (
    <>
      <UnstyledButton onClick={open} aria-label={`Health: ${text}`} data-testid="health" data-state={health.state}>
        <Badge
          variant="light"
          size="lg"
          tt="none"
          color={COLORS[health.state]}
          leftSection={
            health.state === "ok" ? <IconCircleCheckFilled size={14} /> : <IconAlertTriangleFilled size={14} />
          }
          style={{ cursor: "pointer", flex: "none" }}
        >
          {text}
        </Badge>
      </UnstyledButton>
      <HealthDrawer health={health} opened={opened} onClose={close} />
    </>
  );
}
