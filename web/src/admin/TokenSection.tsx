/** Tokens: issue one for a script or a robot, see which are used, revoke. */
import { ActionIcon, Button, Group, Paper, Select, Stack, Table, Text, TextInput, Title } from "@mantine/core";
import { IconKey, IconTrash } from "@tabler/icons-react";
import { useState, type SubmitEvent } from "react";
import { act } from "../api/action";
import { call } from "../api/client";
import type { NewTokenView, Role } from "../api/types";
import { useLab } from "../app/lab";
import { formatStamp } from "../ui/format";
import { Secret } from "./Secret";
import { useList } from "./use-list";

const ROLES: Role[] = ["viewer", "operator", "admin", "robot"];
const fetchTokens = () => call("get", "/api/tokens");

export function TokenSection() {
  const [tokens, refresh] = useList("tokens", fetchTokens);
  const [issued, setIssued] = useState<NewTokenView | null>(null);

  const revoke = async (id: string, name: string) => {
    const path = { token_id: id };
    await act(`Revoking ${name}`, () => call("delete", "/api/tokens/{token_id}", { path }));
    refresh();
  };
  return (
    <Paper withBorder p="md">
      <Title order={2} fz="h5" mb="sm">
        API tokens
      </Title>
      <Stack>
        <NewTokenForm
          onIssued={(token) => {
            setIssued(token);
            refresh();
          }}
        />
        {issued && <Secret what={`Token ${issued.name}`} text={issued.token} onClose={() => setIssued(null)} />}
        {tokens?.length === 0 && (
          <Text size="sm" c="dimmed">
            No token yet. A program sends one as “Authorization: Bearer TOKEN”.
          </Text>
        )}
        <Table verticalSpacing={5} fz="sm" data-testid="tokens">
          <Table.Tbody>
            {tokens?.map((token) => (
              <Table.Tr key={token.id}>
                <Table.Td>
                  {token.name}
                  <Text size="xs" c="dimmed">
                    {token.last_used_ns === null ? "never used" : `last used ${formatStamp(token.last_used_ns)}`} · by{" "}
                    {token.created_by}
                  </Text>
                </Table.Td>
                <Table.Td>{token.robot === null ? token.role : `robot ${token.robot}`}</Table.Td>
                <Table.Td w={44}>
                  <ActionIcon
                    variant="subtle"
                    color="gray"
                    aria-label={`Revoke ${token.name}`}
                    onClick={() => void revoke(token.id, token.name)}
                  >
                    <IconTrash size={16} />
                  </ActionIcon>
                </Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </Stack>
    </Paper>
  );
}

function NewTokenForm({ onIssued }: { readonly onIssued: (token: NewTokenView) => void }) {
  const lab = useLab();
  const [name, setName] = useState("");
  const [role, setRole] = useState<Role>("operator");
  const [robot, setRobot] = useState<string | null>(null);
  const issue = async (event: SubmitEvent) => {
    event.preventDefault();
    await act(`Issuing ${name}`, async () => {
      const body = { name, role, robot: role === "robot" ? robot : null };
      onIssued(await call("post", "/api/tokens", { body }));
      setName("");
    });
  };
  return (
    <form onSubmit={(event) => void issue(event)}>
      <Group align="flex-end">
        <TextInput
          size="xs"
          flex={1}
          label="Name"
          required
          value={name}
          data-testid="token-name"
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <Select
          size="xs"
          w={110}
          label="Role"
          allowDeselect={false}
          data={ROLES}
          value={role}
          onChange={(value) => value !== null && setRole(value)}
        />
        {role === "robot" && (
          <Select
            size="xs"
            w={130}
            label="Robot"
            required
            data={lab?.vehicles.map(({ id }) => id) ?? []}
            value={robot}
            onChange={setRobot}
          />
        )}
        <Button size="xs" type="submit" leftSection={<IconKey size={16} />} data-testid="token-issue">
          Issue
        </Button>
      </Group>
    </form>
  );
}
