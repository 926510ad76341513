/** Gives a user a new password. */
import { Button, Group, Modal, PasswordInput, Stack, Text } from "@mantine/core";
import { useState, type SubmitEvent } from "react";
import { act, showDone } from "../api/action";
import { call } from "../api/client";

interface NewPasswordProps {
  /** Whose; null: nobody's, closed. */
  readonly user: string | null;
  readonly onClose: () => void;
}

export function NewPassword({ user, onClose }: NewPasswordProps) {
  const [password, setPassword] = useState("");
  const close = () => {
    setPassword("");
    onClose();
  };
  const save = async (event: SubmitEvent) => {
    event.preventDefault();
    if (user === null) return;
    const done = await act(`The password of ${user}`, () =>
      call("put", "/api/users/{name}", { path: { name: user }, body: { password } }),
    );
    if (!done) return;
    showDone(`Password of ${user} changed`);
    close();
  };
  return (
    <Modal opened={user !== null} onClose={close} title={`New password for ${user ?? ""}`} centered>
      <form onSubmit={(event) => void save(event)}>
        <Stack>
          <Text size="sm">Their sessions end, on every device.</Text>
          <PasswordInput
            label="New password"
            autoComplete="new-password"
            required
            data-autofocus
            value={password}
            onChange={(event) => setPassword(event.currentTarget.value)}
          />
          <Group justify="flex-end">
            <Button type="submit">Change</Button>
          </Group>
        </Stack>
      </form>
    </Modal>
  );
}
