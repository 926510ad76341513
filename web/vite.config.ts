import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

const server = process.env["LILLIPUT_SERVER"] ?? "http://127.0.0.1:8000";

export default defineConfig({
  plugins: [react()],
  build: { target: "es2023", chunkSizeWarningLimit: 700 },
  server: {
    proxy: {
      "/api": { target: server, ws: true },
      "/viser": { target: server, ws: true },
    },
  },
  test: { include: ["tests/**/*.test.{ts,tsx}"] },
});
