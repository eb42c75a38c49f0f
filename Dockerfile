# Builds Musher's Debian packages, and an image that has them installed. See docs/install.md.
#
#   docker build --tag musher .                            # a robot
#   docker build --target module --tag musher-module .     # and what builds a module for it

# What scripts/test needs, for .devcontainer: work on Musher itself.
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

FROM debian:bookworm-slim AS robot
COPY --from=packages /musher/build/package/packages/*.deb /packages/
RUN apt-get update \
  && apt-get install --yes --no-install-recommends \
    /packages/musher_*.deb /packages/musher-modules_*.deb /packages/musher-view_*.deb \
  && rm -rf /packages /var/lib/apt/lists/*

# The same robot, and what builds and tests a module of one's own: a C++ or Python project of `musher new`.
FROM robot AS module
COPY --from=packages /musher/build/package/packages/*.deb /packages/
RUN apt-get update \
  && apt-get install --yes --no-install-recommends \
    /packages/libmusher-dev_*.deb /packages/python3-musher_*.deb cmake g++ gdb git libgtest-dev make \
  && rm -rf /packages /var/lib/apt/lists/*

FROM robot
# `musher up` is process 1: SIGTERM takes the robot down, within shutdown_budget_ms of its config.
CMD ["musher", "up", "/usr/share/musher/examples/robot.toml"]
