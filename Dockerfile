# Builds Musher's Debian packages, and an image that has them installed. See docs/install.md.
#
#   docker build --tag musher .

# What scripts/test needs, for .devcontainer.
FROM debian:bookworm AS develop
WORKDIR /musher
COPY scripts/bootstrap scripts/
COPY test/view/package.json test/view/package-lock.json test/view/
RUN scripts/bootstrap

FROM debian:bookworm AS packages
WORKDIR /musher
COPY scripts/bootstrap scripts/
RUN scripts/bootstrap --build
COPY . .
RUN cmake --preset package && cmake --build --preset package && cpack --preset package

FROM debian:bookworm-slim
COPY --from=packages /musher/build/package/packages/*.deb /packages/
RUN apt-get update \
  && apt-get install --yes --no-install-recommends \
    /packages/musher_*.deb /packages/musher-modules_*.deb /packages/musher-view_*.deb \
  && rm -rf /packages /var/lib/apt/lists/*
# `musher up` is process 1: SIGTERM takes the robot down, within shutdown_budget_ms of its config.
CMD ["musher", "up", "/usr/share/musher/examples/robot.toml"]
