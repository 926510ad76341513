/** Starts a saved route on a robot. */
import { Button, Group, Select } from "@mantine/core";
import { IconPlayerPlay } from "@tabler/icons-react";
import { useState } from "react";
import { act, showDone } from "../api/action";
import { call } from "../api/client";
import { useLive } from "../live/store";
import { isFree, summarize } from "../fleet/robot-state";
import { Guarded } from "../ui/Guarded";

export function StartOnRobot({ route, isSaved }: { readonly route: string; readonly isSaved: boolean }) {
  const robots = useLive((live) => live.state.robots);
  const [chosen, setChosen] = useState<string | null>(null);
  const free = Object.values(robots).filter(isFree);
  const robot = free.some(({ id }) => id === chosen) ? chosen : (free[0]?.id ?? null);

  const start = async (id: string) => {
    const body = { route, speed_scale: 1 };
    const done = await act(`Starting ${route} on ${id}`, () =>
      call("put", "/api/robots/{robot_id}/assignment", { path: { robot_id: id }, body }),
    );
    if (done) showDone(`${id} drives ${route}`);
  };
  return (
    <Group align="flex-end" wrap="nowrap">
      <Select
        size="xs"
        flex={1}
        label="Start on"
        placeholder="every robot has a route"
        allowDeselect={false}
        data={free.map((candidate) => ({
          value: candidate.id,
          label: `${candidate.id} (${summarize(candidate).word.toLowerCase()})`,
        }))}
        value={robot}
        data-testid="start-robot"
        onChange={setChosen}
      />
      <Guarded {...(!isSaved && { hint: "Save the route first" })}>
        <Button
          size="xs"
          leftSection={<IconPlayerPlay size={16} />}
          disabled={robot === null || !isSaved}
          data-testid="start-on-robot"
          onClick={() => robot !== null && void start(robot)}
        >
          Start
        </Button>
      </Guarded>
    </Group>
  );
}
