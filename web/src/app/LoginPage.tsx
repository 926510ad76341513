/** The way in. */
import { Alert, Button, Center, Code, Paper, PasswordInput, Stack, Text, TextInput, Title } from "@mantine/core";
import { useDocumentTitle } from "@mantine/hooks";
import { useState, type SubmitEvent } from "react";
import { ApiError } from "../api/client";
import { logIn } from "./session";

export function LoginPage({ ended }: { readonly ended: boolean }) {
  const [user, setUser] = useState("admin");
  const [password, setPassword] = useState("");
  const [error, setError] = useState<string | null>(null);
  const [busy, setBusy] = useState(false);
  useDocumentTitle("Log in · Lilliput");

  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    setBusy(true);
    setError(null);
    try {
      await logIn(user.trim(), password);
    } catch (refused) {
      setError(refused instanceof ApiError ? refused.message : String(refused));
      setBusy(false);
    }
  };
  return (
    <Center mih="100dvh" p="md">
      <Paper withBorder shadow="md" p="xl" w={380} maw="100%">
        <form onSubmit={(event) => void submit(event)}>
          <Stack>
            <Stack gap={4} align="center">
              <img src="/icon.svg" alt="" width={48} height={48} />
              <Title order={1} fz="h3">
                Lilliput
              </Title>
              <Text size="sm" c="dimmed">
                Control room
              </Text>
            </Stack>
            {ended && error === null && <Alert color="orange">Your session has ended. Log in again.</Alert>}
            {error !== null && (
              <Alert color="red" role="alert" data-testid="login-error">
                {error}
              </Alert>
            )}
            <TextInput
              label="User"
              name="username"
              autoComplete="username"
              required
              withAsterisk={false}
              value={user}
              data-testid="login-user"
              onChange={(event) => setUser(event.currentTarget.value)}
            />
            <PasswordInput
              label="Password"
              name="password"
              autoComplete="current-password"
              required
              withAsterisk={false}
              autoFocus
              value={password}
              data-testid="login-password"
              onChange={(event) => setPassword(event.currentTarget.value)}
            />
            <Button type="submit" loading={busy} data-testid="login-submit">
              Log in
            </Button>
            <Text size="xs" c="dimmed">
              First time here? The first start printed the password of <Code>admin</Code> in the terminal where{" "}
              <Code>./lilliput up</Code> runs.
            </Text>
          </Stack>
        </form>
      </Paper>
    </Center>
  );
}
