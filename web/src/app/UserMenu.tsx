/** Who is logged in, the colour scheme and the way out. */
import {
  ActionIcon,
  Menu,
  SegmentedControl,
  Text,
  useMantineColorScheme,
  type MantineColorScheme,
} from "@mantine/core";
import { IconLogout, IconUserCircle } from "@tabler/icons-react";
import { act } from "../api/action";
import { logOut, useSession } from "./session";

const SCHEMES = [
  { value: "light", label: "Light" },
  { value: "dark", label: "Dark" },
  { value: "auto", label: "System" },
];

export function UserMenu() {
  const session = useSession();
  const { colorScheme, setColorScheme } = useMantineColorScheme();
  if (session.state !== "in") return null;
  return (
    <Menu position="bottom-end" width={240}>
      <Menu.Target>
        <ActionIcon variant="subtle" color="gray" size="lg" aria-label={`User ${session.user}`} data-testid="user-menu">
          <IconUserCircle size={24} stroke={1.6} />
        </ActionIcon>
      </Menu.Target>
      <Menu.Dropdown>
        <Menu.Label>
          <Text span fw={600} c="bright">
            {session.user}
          </Text>{" "}
          · {session.role}
        </Menu.Label>
        <Menu.Label>
          <SegmentedControl
            fullWidth
            size="xs"
            aria-label="Colour scheme"
            data-testid="color-scheme"
            data={SCHEMES}
            value={colorScheme}
            onChange={(value) => setColorScheme(value as MantineColorScheme)}
          />
        </Menu.Label>
        <Menu.Divider />
        <Menu.Item
          leftSection={<IconLogout size={16} />}
          data-testid="logout"
          onClick={() => void act("Logging out", logOut)}
        >
          Log out
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}
