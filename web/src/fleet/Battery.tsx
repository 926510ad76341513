/** A battery's charge; a warning below 30 %, an alarm below 10 %. */
import { Group, Text } from "@mantine/core";
import { IconBattery1, IconBattery2, IconBattery3, IconBattery4 } from "@tabler/icons-react";

export function Battery({ share }: { readonly share: number }) {
  const color = share > 0.3 ? undefined : share > 0.1 ? "orange" : "red";
  const Symbol = share > 0.75 ? IconBattery4 : share > 0.5 ? IconBattery3 : share > 0.25 ? IconBattery2 : IconBattery1;
  return (
    <Group
      gap={3}
      wrap="nowrap"
      c={color ?? "dimmed"}
      role="img"
      aria-label={`Battery ${Math.round(share * 100)} percent`}
    >
      <Symbol size={15} stroke={1.6} />
      <Text span size="xs" fw={color ? 700 : 400}>
        {Math.round(share * 100)} %
      </Text>
    </Group>
  );
}
