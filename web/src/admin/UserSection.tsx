/** Users: create, change the role, give a new password, delete. */
import { ActionIcon, Button, Group, Paper, Select, Stack, Table, Text, TextInput, Title, Tooltip } from "@mantine/core";
import { IconKey, IconTrash, IconUserPlus } from "@tabler/icons-react";
import { useState, type SubmitEvent } from "react";
import { act } from "../api/action";
import { call } from "../api/client";
import type { Role } from "../api/types";
import { useSession } from "../app/session";
import { formatStamp } from "../ui/format";
import { NewPassword } from "./NewPassword";
import { Secret } from "./Secret";
import { useList } from "./use-list";

const ROLES: Role[] = ["viewer", "operator", "admin"];
const fetchUsers = () => call("get", "/api/users");

export function UserSection() {
  const [users, refresh] = useList("users", fetchUsers);
  const [made, setMade] = useState<{ name: string; password: string } | null>(null);
  const [changing, setChanging] = useState<string | null>(null);
  const me = useSession((session) => (session.state === "in" ? session.user : ""));

  const change = async (name: string, role: Role) => {
    await act(`Changing ${name}`, () => call("put", "/api/users/{name}", { path: { name }, body: { role } }));
    refresh();
  };
  const remove = async (name: string) => {
    await act(`Deleting ${name}`, () => call("delete", "/api/users/{name}", { path: { name } }));
    refresh();
  };
  return (
    <Paper withBorder p="md">
      <Title order={2} fz="h5" mb="sm">
        Users
      </Title>
      <Stack>
        <NewUserForm
          onMade={(name, password) => {
            setMade({ name, password });
            refresh();
          }}
        />
        {made && <Secret what={`Password of ${made.name}`} text={made.password} onClose={() => setMade(null)} />}
        <Table verticalSpacing={5} fz="sm" data-testid="users">
          <Table.Tbody>
            {users?.map(({ name, role, created_ns }) => (
              <Table.Tr key={name}>
                <Table.Td>
                  {name}
                  <Text size="xs" c="dimmed">
                    since {formatStamp(created_ns)}
                    {name === me && " · you"}
                  </Text>
                </Table.Td>
                <Table.Td w={130}>
                  <Select
                    size="xs"
                    aria-label={`Role of ${name}`}
                    allowDeselect={false}
                    data={ROLES}
                    value={role}
                    onChange={(value) => value !== null && void change(name, value)}
                  />
                </Table.Td>
                <Table.Td w={76}>
                  <Group gap={4} wrap="nowrap">
                    <Tooltip label="New password">
                      <ActionIcon
                        variant="subtle"
                        color="gray"
                        aria-label={`New password for ${name}`}
                        onClick={() => setChanging(name)}
                      >
                        <IconKey size={16} />
                      </ActionIcon>
                    </Tooltip>
                    <ActionIcon
                      variant="subtle"
                      color="gray"
                      aria-label={`Delete ${name}`}
                      disabled={name === me}
                      onClick={() => void remove(name)}
                    >
                      <IconTrash size={16} />
                    </ActionIcon>
                  </Group>
                </Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </Stack>
      <NewPassword user={changing} onClose={() => setChanging(null)} />
    </Paper>
  );
}

function NewUserForm({ onMade }: { readonly onMade: (name: string, password: string) => void }) {
  const [name, setName] = useState("");
  const [role, setRole] = useState<Role>("operator");
  const create = async (event: SubmitEvent) => {
    event.preventDefault();
    await act(`Creating ${name}`, async () => {
      const user = await call("post", "/api/users", { body: { name, role } });
      setName("");
      onMade(user.name, user.password ?? "");
    });
  };
  return (
    <form onSubmit={(event) => void create(event)}>
      <Group align="flex-end">
        <TextInput
          size="xs"
          flex={1}
          label="Name"
          required
          value={name}
          data-testid="user-name"
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <Select
          size="xs"
          w={120}
          label="Role"
          allowDeselect={false}
          data={ROLES}
          value={role}
          onChange={(value) => value !== null && setRole(value)}
        />
        <Button size="xs" type="submit" leftSection={<IconUserPlus size={16} />} data-testid="user-create">
          Create
        </Button>
      </Group>
    </form>
  );
}
