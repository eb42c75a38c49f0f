# Compiles for 64-bit ARM on another computer: with Debian's crossbuild-essential-arm64, and with the libraries of
# Debian's arm64 beside those of the computer (dpkg --add-architecture arm64, then lib…-dev:arm64). The presets arm64
# and arm64-package use it; scripts/roots makes a system that has all of it.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_STRIP aarch64-linux-gnu-strip)

# Debian has the libraries of each architecture in a folder of their own, and no root besides "/".
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(PKG_CONFIG_EXECUTABLE /usr/bin/aarch64-linux-gnu-pkg-config)

# Tests, and programs that a build runs, such as those whose help becomes a manual page.
find_program(MUSHER_QEMU_AARCH64 NAMES qemu-aarch64-static qemu-aarch64)
if(MUSHER_QEMU_AARCH64)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${MUSHER_QEMU_AARCH64})
endif()
